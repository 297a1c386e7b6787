#include <memory>
#include <ostream>

#include "client/cli/commands.h"
#include "client/cli/files.h"
#include "client/cli/load.h"
#include "client/cli/place.h"
#include "client/smoothing_client.h"

namespace burnish::cli {
namespace {

struct BenchArguments {
  std::string mesh, method;
  double duration = 10;
  LoadOptions load;
  Place place;
  bool json = false;
};

Result<> bench(const BenchArguments& arguments, const Console& console) {
  if (arguments.place.server.empty()) return Error{Cause::BadOption, "--server is required"};
  Result<std::string> mesh = read_file(arguments.mesh);
  if (!mesh) return mesh.error();
  v1::SmoothRequest request;
  request.set_mesh(std::move(mesh).value());
  request.mutable_options()->set_method(arguments.method);
  const auto client = connect(arguments.place);
  if (!client) return client.error();
  const auto given = call_options(arguments.place, console);
  if (!given) return given.error();
  const client::CallOptions& options = *given;
  // The first call opens the connection, and says what would be wrong with all of them.
  if (auto first = client->smooth(request, options); !first && first.error().code == grpc::INVALID_ARGUMENT)
    return error_from(first.error(), arguments.place);
  LoadOptions load_options = arguments.load;
  load_options.duration = std::chrono::duration<double>(arguments.duration);
  const LoadOutcome outcome = load(
      load_options,
      [&] {
        const auto reply = client->smooth(request, options);
        return reply ? std::string("ok") : reply.error().cause;
      },
      console.stop);
  if (arguments.json) {
    console.out << load_json(outcome);
  } else {
    print_load(console.out, outcome);
  }
  if (outcome.latencies.empty())
    return Error{Cause::Unreachable, "no call was answered by " + arguments.place.server};
  return {};
}

}  // namespace

void add_bench_command(CLI::App& app, Command& chosen) {
  auto arguments = std::make_shared<BenchArguments>();
  CLI::App* command = app.add_subcommand("bench", "Load a server with calls and tell how it bears them");
  command->add_option("--server", arguments->place.server, "The burnishd at HOST:PORT or unix:PATH (gRPC)")
      ->type_name("ADDRESS");
  add_token_file(command, arguments->place);
  add_tls(command, arguments->place);
  command->add_option("--mesh", arguments->mesh, "The mesh of every call")->type_name("FILE")->required();
  command->add_option("--method", arguments->method, "Its method; default: the server's")
      ->type_name("METHOD");
  command->add_option("--concurrency", arguments->load.concurrency, "Calls at once")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  command
      ->add_option(
          "--rate", arguments->load.rate,
          "Calls that are due a second, whether or not others are answered; 0: as fast as answers come")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  command->add_option("--duration", arguments->duration, "Seconds")
      ->check(CLI::Range(0.01, 1e6))
      ->capture_default_str();
  command->add_option("--timeout", arguments->place.timeout_seconds, "Of each call, in seconds")
      ->check(CLI::Range(0.001, 1e6));
  arguments->place.retries = 0;  // a refusal is an outcome
  command->add_option("--retries", arguments->place.retries, "How often a call tries again")
      ->check(CLI::Range(0, 100))
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "Print JSON");
  command->callback([&chosen, arguments] {
    chosen = [arguments](const Console& console) { return bench(*arguments, console); };
  });
}

}  // namespace burnish::cli
