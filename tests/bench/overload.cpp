// Loads a running burnishd with many callers at once and prints what became of them: with as many callers as
// it takes, with ten times as many, and with as many as it takes again. Goodput, the processor time that the
// server used, the share of it that was for jobs and what each of these took (the machine's speed changes
// goodput and the last alike, and leaves the share alone), how fast the surplus was refused, and
// the memory of the server and its helpers.
//   overload HTTP_PORT GRPC_ADDRESS SERVER_PID MESH.obj [SECONDS=60] [CALLERS=66] [http|grpc]
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "burnish/v1/smoothing.pb.h"
#include "client/status_error.h"
#include "tests/server/raw_http.h"

namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

enum class Ending { Done, Refused, Failed };

struct Answer {
  Ending ending = Ending::Failed;
  double retry_seconds = 0;  ///< of a refusal; 0: it named none
};

using Call = std::function<Answer()>;

struct Tally {
  std::mutex mutex;
  std::vector<double> done, refused;  ///< seconds each
  std::size_t failed = 0, without_retry = 0;
};

std::string read_file(const std::string& path) {
  std::ostringstream bytes;
  bytes << std::ifstream(path, std::ios::binary).rdbuf();
  return bytes.str();
}

/// In clock ticks, so far.
double processor_time(const std::string& pid) {
  std::ifstream stat("/proc/" + pid + "/stat");
  std::string text;
  std::getline(stat, text);
  std::istringstream fields(text.substr(text.rfind(')') + 2));  // the name before it may hold anything
  std::string skipped;
  for (int i = 0; i < 11; ++i) fields >> skipped;
  double user = 0, kernel = 0;
  fields >> user >> kernel;
  return user + kernel;
}

/// The processes of its helpers.
std::vector<std::string> helpers_of(const std::string& pid) {
  std::vector<std::string> helpers;
  for (const auto& thread : std::filesystem::directory_iterator("/proc/" + pid + "/task")) {
    std::ifstream children(thread.path() / "children");
    for (std::string helper; children >> helper;) helpers.push_back(helper);
  }
  return helpers;
}

struct ProcessorTime {
  double server = 0, helpers = 0;

  static ProcessorTime of(const std::string& pid) {
    ProcessorTime time{.server = processor_time(pid)};
    for (const std::string& helper : helpers_of(pid)) time.helpers += processor_time(helper);
    return time;
  }
};

/// Of one process: "Rss", all that is resident, or "Anonymous", what is not of files.
double megabytes_of(const std::string& pid, const std::string& kind) {
  std::ifstream rollup("/proc/" + pid + "/smaps_rollup");
  for (std::string line; std::getline(rollup, line);) {
    if (line.starts_with(kind + ":")) return std::strtod(line.c_str() + kind.size() + 1, nullptr) / 1024;
  }
  return 0;
}

/// Of the server and its helpers, which run the same program: its pages count once.
double memory_megabytes(const std::string& pid) {
  double sum = megabytes_of(pid, "Rss");
  for (const std::string& helper : helpers_of(pid)) sum += megabytes_of(helper, "Anonymous");
  return sum;
}

Call over_http(int port, const std::string& mesh) {
  return [port, &mesh, connection = std::make_shared<std::unique_ptr<burnish::testing::RawHttp>>()] {
    const auto ask = [&] {
      if (!*connection) *connection = std::make_unique<burnish::testing::RawHttp>(port);
      (*connection)->send_request("POST", "/v1/smooth", mesh);
      return (*connection)->read_response();
    };
    auto response = ask();
    if (response.status == 0) {  // the connection was idle for too long meanwhile
      connection->reset();
      response = ask();
    }
    const auto field = [&response](const char* name) {
      const auto found = response.headers.find(name);
      return found == response.headers.end() ? std::string() : found->second;
    };
    if (response.status == 0 || field("Connection") == "close") connection->reset();
    if (response.status == 200) return Answer{Ending::Done};
    if (response.status != 429 && response.status != 503) return Answer{};
    return Answer{Ending::Refused, std::strtod(field("Retry-After").c_str(), nullptr)};
  };
}

/// Each on a connection of its own, as callers are. All send the same bytes: hundreds of callers that write
/// their message at once would take their core longer than the server takes to answer.
Call over_grpc(const std::string& address, const grpc::ByteBuffer& request) {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(-1);
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  const auto channel = grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
  channel->WaitForConnected(std::chrono::system_clock::now() + std::chrono::seconds(10));
  return [stub = std::make_shared<grpc::GenericStub>(channel), &request] {
    grpc::ClientContext context;
    grpc::ByteBuffer response;
    std::promise<grpc::Status> ended;
    stub->UnaryCall(&context, "/burnish.v1.SmoothingService/Smooth", {}, &request, &response,
                    [&ended](grpc::Status status) { ended.set_value(std::move(status)); });
    const auto status = ended.get_future().get();
    if (status.ok()) return Answer{Ending::Done};
    const auto error = burnish::client::error_from(status);
    if (error.cause != "queue_full" && error.cause != "memory_full") return Answer{};
    return Answer{Ending::Refused, Seconds(error.retry_after).count()};
  };
}

/// One caller: asks again as soon as it is answered, or when it was told to.
void call_until(Clock::time_point end, const Call& call, Tally& tally) {
  while (Clock::now() < end) {
    const auto start = Clock::now();
    const Answer answer = call();
    const double took = Seconds(Clock::now() - start).count();
    {
      const std::lock_guard lock(tally.mutex);
      if (answer.ending == Ending::Done) tally.done.push_back(took);
      if (answer.ending == Ending::Refused) tally.refused.push_back(took);
      tally.failed += answer.ending == Ending::Failed;
      tally.without_retry += answer.ending == Ending::Refused && answer.retry_seconds <= 0;
    }
    if (answer.ending == Ending::Refused) {
      std::this_thread::sleep_until(std::min(
          end, Clock::now() + std::chrono::duration_cast<Clock::duration>(Seconds(answer.retry_seconds))));
    }
  }
}

double quantile(std::vector<double>& values, double share) {
  if (values.empty()) return 0;
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

void load(const char* name, int callers, double seconds, const std::string& pid,
          const std::function<Call()>& new_call) {
  Tally tally;
  const double before = memory_megabytes(pid);
  std::atomic<double> most = before;
  std::vector<Call> calls;
  const auto start = ProcessorTime::of(pid);
  for (int i = 0; i < callers; ++i) calls.push_back(new_call());
  const auto end = Clock::now() + std::chrono::duration_cast<Clock::duration>(Seconds(seconds));
  {
    std::vector<std::jthread> threads;
    for (const Call& call : calls) threads.emplace_back([&] { call_until(end, call, tally); });
    while (Clock::now() < end) {
      most = std::max(most.load(), memory_megabytes(pid));
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  }
  const auto used = ProcessorTime::of(pid);
  const double tick = 1.0 / static_cast<double>(sysconf(_SC_CLK_TCK));
  const double jobs = tick * (used.helpers - start.helpers), rest = tick * (used.server - start.server);
  const auto answers = static_cast<double>(tally.done.size());
  calls.clear();
  std::this_thread::sleep_for(std::chrono::seconds(12));  // idle threads end, freed memory goes back
  std::printf(
      "%-6s %4d callers: %6.1f answers/s, %.2f cores busy, %.1f%% of it jobs, %.2f ms each; %zu refused (%zu "
      "without a "
      "retry time), %zu failed; answered in %.0f ms (median), refused in %.1f ms (median), %.1f ms (99%%); "
      "memory %.1f -> %.1f -> %.1f MB\n",
      name, callers, answers / seconds, (jobs + rest) / seconds, 100 * jobs / (jobs + rest),
      1000 * jobs / answers, tally.refused.size(), tally.without_retry, tally.failed,
      1000 * quantile(tally.done, 0.5), 1000 * quantile(tally.refused, 0.5),
      1000 * quantile(tally.refused, 0.99), before, most.load(), memory_megabytes(pid));
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5) {
    std::fprintf(
        stderr,
        "usage: overload HTTP_PORT GRPC_ADDRESS SERVER_PID MESH.obj [SECONDS] [CALLERS] [http|grpc]\n");
    return 2;
  }
  const int port = std::atoi(argv[1]);
  const std::string mesh = read_file(argv[4]);
  burnish::v1::SmoothRequest message;
  message.set_mesh(mesh);
  const grpc::Slice bytes(message.SerializeAsString());
  const grpc::ByteBuffer request(&bytes, 1);
  const double seconds = argc > 5 ? std::strtod(argv[5], nullptr) : 60;
  const int callers = argc > 6 ? std::atoi(argv[6]) : 66;
  const std::string only = argc > 7 ? argv[7] : "";
  for (const int times : {1, 10, 1}) {
    if (only == "grpc") break;
    load("http", times * callers, seconds, argv[3], [&] { return over_http(port, mesh); });
  }
  for (const int times : {1, 10, 1}) {
    if (only == "http") break;
    load("grpc", times * callers, seconds, argv[3], [&] { return over_grpc(argv[2], request); });
  }
}
