// What the transports add: calls a running burnishd one after the other and prints the median of the time
// from end to end, of the server's own stages, and of the difference.
//   overhead HTTP_PORT GRPC_ADDRESS MESH.obj [CALLS=200]
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "client/smoothing_client.h"
#include "tests/server/raw_http.h"

namespace {

using Clock = std::chrono::steady_clock;

std::string read_file(const std::string& path) {
  std::ostringstream bytes;
  bytes << std::ifstream(path, std::ios::binary).rdbuf();
  return bytes.str();
}

/// Sum of the stages in a Burnish-Report header.
double stages_of(const std::string& report) {
  double sum = 0;
  const std::regex stage(R"x("(queue|decode|prepare|smooth|measure|encode)Ms":([0-9.e+-]+))x");
  for (std::sregex_iterator at(report.begin(), report.end(), stage), end; at != end; ++at) {
    sum += std::strtod((*at)[2].str().c_str(), nullptr);
  }
  return sum;
}

double stages_of(const burnish::v1::StageTimings& t) {
  return t.queue_ms() + t.decode_ms() + t.prepare_ms() + t.smooth_ms() + t.measure_ms() + t.encode_ms();
}

double median(std::vector<double> values) {
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
  return values[values.size() / 2];
}

/// `call` returns the milliseconds of the server's stages; negative when it failed.
void measure(const char* name, int calls, const std::function<double()>& call) {
  std::vector<double> whole, stages, rest;
  for (int i = 0; i < calls; ++i) {
    const auto start = Clock::now();
    const double inside = call();
    const double took = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    if (inside < 0) {
      std::printf("%s: a call failed\n", name);
      return;
    }
    whole.push_back(took);
    stages.push_back(inside);
    rest.push_back(took - inside);
  }
  std::printf("%-12s end to end %6.2f ms, stages %6.2f ms, overhead %5.2f ms (%.1f%%)\n", name, median(whole),
              median(stages), median(rest), 100 * median(rest) / median(whole));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "usage: overhead HTTP_PORT GRPC_ADDRESS MESH.obj [CALLS]\n");
    return 2;
  }
  const burnish::client::SmoothingClient client(argv[2]);
  const std::string mesh = read_file(argv[3]);
  const int calls = argc > 4 ? std::atoi(argv[4]) : 200;
  burnish::v1::SmoothRequest request;
  request.set_mesh(mesh);
  const auto grpc = [&](const burnish::client::CallOptions& options) {
    const auto answer = client.smooth(request, options);
    return answer ? stages_of(answer->report().timings()) : -1;
  };
  measure("grpc unary", calls, [&] { return grpc({}); });
  measure("grpc stream", calls, [&] { return grpc({.unary_bytes = 0}); });

  const int port = std::atoi(argv[1]);
  auto connection = std::make_unique<burnish::testing::RawHttp>(port);
  measure("http", calls, [&] {
    connection->send_request("POST", "/v1/smooth", mesh);
    const auto response = connection->read_response();
    const bool closes =
        response.headers.contains("Connection") && response.headers.at("Connection") == "close";
    if (closes) connection = std::make_unique<burnish::testing::RawHttp>(port);
    return response.status == 200 ? stages_of(response.headers.at("Burnish-Report")) : -1;
  });
}
