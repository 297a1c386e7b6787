// smooth_scan ADDRESS IN OUT: smooths a scan with the defaults, tells how far it is, and what was done.
#include <burnish/client/smoothing_client.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>

namespace {

void show(const burnish::v1::SmoothProgress& now) {
  std::cerr << burnish::v1::SmoothStage_Name(now.stage()) << " " << static_cast<int>(100 * now.fraction())
            << " %\n";
}

void tell(const burnish::v1::SmoothReport& report) {
  std::cout << report.method() << ": " << report.input().triangles() << " triangles with noise of "
            << report.noise().sigma_over_edge() << " mean edges, moved by "
            << report.change().max_displacement() << " at most, in " << report.timings().total_ms()
            << " ms\n";
  for (const auto& warning : report.warnings()) std::cout << "note: " << warning.message() << "\n";
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::cerr << "usage: smooth_scan ADDRESS IN OUT\n";
    return 2;
  }
  std::ifstream in(argv[2], std::ios::binary);
  burnish::v1::SmoothRequest request;
  request.set_mesh(std::string(std::istreambuf_iterator<char>(in), {}));
  if (!in) {
    std::cerr << "cannot read " << argv[2] << "\n";
    return 1;
  }

  // A full or restarting server is tried again within the timeout; a larger mesh goes by stream by itself.
  burnish::client::CallOptions options;
  options.timeout = std::chrono::minutes(2);
  options.progress = show;
  if (const char* token = std::getenv("BURNISH_TOKEN")) options.token = token;

  const burnish::client::SmoothingClient client(argv[1]);
  const auto result = client.smooth(request, options);
  if (!result) {
    std::cerr << result.error().cause << ": " << result.error().message << "\n";
    return 1;
  }
  std::ofstream out(argv[3], std::ios::binary);
  out << result->mesh();
  tell(result->report());
  return out.flush() ? 0 : 1;
}
