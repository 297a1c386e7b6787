#include "client/retry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <limits>
#include <set>

#include "client/smoothing_client.h"
#include "tests/client/fake_server.h"
#include "tests/client/temporary_folder.h"

namespace burnish::client {
namespace {

using namespace std::chrono_literals;
using cli::TemporaryFolder;
using std::chrono::milliseconds;
using ::testing::ElementsAre;

/// A policy that notes its waits instead of waiting; the jitter is always the same.
struct Notes {
  RetryPolicy policy(double jitter = 0.5) {
    return {.jitter = [jitter] { return jitter; },
            .wait =
                [this](milliseconds delay, const std::stop_token&) {
                  waits.push_back(delay);
                  return true;
                }};
  }
  std::vector<milliseconds> waits;
};

Error error_of(const grpc::StatusCode code, const std::string& cause, milliseconds retry_after = {}) {
  return {.code = code, .cause = cause, .message = "why", .retry_after = retry_after};
}

Error unreachable() { return error_of(grpc::StatusCode::UNAVAILABLE, "unreachable"); }

TEST(Retry, GrowsTheDelayUpToTheLongest) {
  Notes notes;
  CallOptions options{.retry = notes.policy()};
  options.retry.attempts = 9;
  Attempts attempts(options);
  Error error = unreachable();
  while (attempts.again(error)) {
  }
  EXPECT_EQ(error.attempts, 9);
  EXPECT_THAT(notes.waits, ElementsAre(50ms, 100ms, 200ms, 400ms, 800ms, 1600ms, 2500ms, 2500ms));
}

TEST(Retry, SpreadsTheDelaysOverTheirWholeRange) {
  Notes notes;
  CallOptions options{.retry = notes.policy()};
  options.retry.jitter = {};
  options.retry.initial_delay = 1000ms;
  for (int i = 0; i < 100; ++i) {
    Attempts attempts(options);
    Error error = unreachable();
    ASSERT_TRUE(attempts.again(error));
  }
  EXPECT_GT(std::set(notes.waits.begin(), notes.waits.end()).size(), 50u);
  EXPECT_LT(std::ranges::min(notes.waits), 200ms);
  EXPECT_GT(std::ranges::max(notes.waits), 800ms);
  EXPECT_LT(std::ranges::max(notes.waits), 1000ms);
}

TEST(Retry, WaitsAtLeastAsLongAsTheServerAsks) {
  Notes notes;
  const CallOptions options{.retry = notes.policy()};
  Attempts attempts(options);
  Error error = error_of(grpc::StatusCode::RESOURCE_EXHAUSTED, "queue_full", 9000ms);
  ASSERT_TRUE(attempts.again(error));
  EXPECT_THAT(notes.waits, ElementsAre(9050ms));
}

TEST(Retry, TriesAgainOnlyWhatPasses) {
  using enum grpc::StatusCode;
  const std::pair<Error, bool> rows[] = {
      {error_of(UNAVAILABLE, "unreachable"), true},
      {error_of(UNAVAILABLE, "shutting_down"), true},
      {error_of(RESOURCE_EXHAUSTED, "queue_full"), true},
      {error_of(RESOURCE_EXHAUSTED, "memory_full"), true},
      {error_of(RESOURCE_EXHAUSTED, "too_large"), false},
      {error_of(RESOURCE_EXHAUSTED, "storage_full"), false},
      {error_of(RESOURCE_EXHAUSTED, "out_of_memory"), false},
      {error_of(INVALID_ARGUMENT, "bad_option"), false},
      {error_of(INVALID_ARGUMENT, "malformed_mesh"), false},
      {error_of(DEADLINE_EXCEEDED, "deadline_exceeded"), false},
      {error_of(CANCELLED, "cancelled"), false},
      {error_of(INTERNAL, "internal"), false},
      {error_of(UNIMPLEMENTED, "internal"), false},
  };
  for (const auto& [error, again] : rows) {
    Notes notes;
    const CallOptions options{.retry = notes.policy()};
    Attempts attempts(options);
    Error failed = error;
    EXPECT_EQ(attempts.again(failed), again) << error.cause;
    EXPECT_EQ(failed.attempts, 1);
  }
}

TEST(Retry, DoesNotWaitForWhatCannotStartInTime) {
  Notes notes;
  const CallOptions options{.timeout = 1000s, .retry = notes.policy()};
  Attempts attempts(options);
  Error soon = error_of(grpc::StatusCode::RESOURCE_EXHAUSTED, "queue_full", 900s);
  EXPECT_TRUE(attempts.again(soon));
  Error late = error_of(grpc::StatusCode::RESOURCE_EXHAUSTED, "queue_full", 1001s);
  EXPECT_FALSE(attempts.again(late));
  EXPECT_EQ(late.cause, "queue_full");
  EXPECT_EQ(late.attempts, 2);
  EXPECT_EQ(notes.waits.size(), 1u);
}

TEST(Retry, TakesAnyNumberForAPolicy) {
  const double inf = std::numeric_limits<double>::infinity();
  for (const double multiplier : {0.0, -3.0, inf, std::nan("")}) {
    for (const milliseconds delay : {milliseconds::min(), milliseconds::zero(), milliseconds::max()}) {
      Notes notes;
      CallOptions options{.timeout = milliseconds::max(), .retry = notes.policy(1)};
      options.retry.initial_delay = options.retry.longest_delay = delay;
      options.retry.multiplier = multiplier;
      Attempts attempts(options);
      Error error = unreachable();
      while (attempts.again(error)) {
      }
      ASSERT_EQ(notes.waits.size(), 3u);
      EXPECT_GE(std::ranges::min(notes.waits), 0ms);
      EXPECT_LE(std::ranges::max(notes.waits), 24h);
    }
  }
}

TEST(Retry, EndsItsWaitWhenItIsStopped) {
  std::promise<void> waits;
  CallOptions options;
  std::stop_source stop;
  options.stop = stop.get_token();
  options.retry.jitter = [&] { return waits.set_value(), 0.5; };
  Attempts attempts(options);
  Error error = error_of(grpc::StatusCode::UNAVAILABLE, "shutting_down", 3600s);
  auto again = std::async(std::launch::async, [&] { return attempts.again(error); });
  waits.get_future().wait();
  stop.request_stop();
  EXPECT_FALSE(again.get());
  EXPECT_EQ(error.code, grpc::StatusCode::CANCELLED);
  EXPECT_EQ(error.cause, "cancelled");
  EXPECT_THAT(error.message, ::testing::HasSubstr("why"));
}

TEST(Retry, WaitsForReal) {
  const CallOptions options{.retry = {.initial_delay = 40ms, .jitter = [] { return 0.5; }}};
  Attempts attempts(options);
  Error error = unreachable();
  const auto start = std::chrono::steady_clock::now();
  EXPECT_TRUE(attempts.again(error));
  EXPECT_GE(std::chrono::steady_clock::now() - start, 20ms);
}

v1::SmoothRequest small_request() {
  v1::SmoothRequest request;
  request.set_mesh("v 0 0 0");
  return request;
}

TEST(RetriedCall, AnswersAfterRefusals) {
  std::atomic<int> calls = 0;
  const FakeServer server({.smooth = [&](auto& context, const auto& request, auto& response) {
    return ++calls < 4 ? queue_full(milliseconds(100 * calls)) : echo(context, request, response);
  }});
  Notes notes;
  const auto reply = SmoothingClient(server.address()).smooth(small_request(), {.retry = notes.policy(0)});
  ASSERT_TRUE(reply.ok()) << reply.error().message;
  EXPECT_EQ(reply->mesh(), "v 0 0 0");
  EXPECT_EQ(calls, 4);
  EXPECT_THAT(notes.waits, ElementsAre(100ms, 200ms, 300ms));
}

TEST(RetriedCall, ReturnsTheLastRefusal) {
  std::atomic<int> calls = 0;
  const FakeServer server(
      {.smooth = [&](auto&, auto&, auto&) { return queue_full(milliseconds(++calls)); },
       .compare = [](auto&, auto&) { return refusal(grpc::StatusCode::UNAVAILABLE, "SHUTTING_DOWN"); }});
  const SmoothingClient client(server.address());
  Notes notes;
  const auto smoothed = client.smooth(small_request(), {.retry = notes.policy(0)});
  ASSERT_FALSE(smoothed.ok());
  EXPECT_EQ(smoothed.error().cause, "queue_full");
  EXPECT_EQ(smoothed.error().retry_after, 4ms);
  EXPECT_EQ(smoothed.error().attempts, 4);
  EXPECT_EQ(calls, 4);
  const auto compared = client.compare({}, {.retry = notes.policy(0)});
  ASSERT_FALSE(compared.ok());
  EXPECT_EQ(compared.error().cause, "shutting_down");
  EXPECT_EQ(compared.error().attempts, 4);
}

TEST(RetriedCall, BoundsWhatAServerAsksFor) {
  google::rpc::RetryInfo retry;
  const std::pair<std::int64_t, milliseconds> rows[] = {
      {std::numeric_limits<std::int64_t>::max(), 24h}, {-5, 0ms}, {2, 2000ms}};
  for (const auto& [seconds, expected] : rows) {
    retry.mutable_retry_delay()->set_seconds(seconds);
    google::rpc::Status details;
    details.add_details()->PackFrom(retry);
    const FakeServer server({.smooth = [text = details.SerializeAsString()](auto&, auto&, auto&) {
      return grpc::Status(grpc::StatusCode::UNAVAILABLE, "later", text);
    }});
    const auto reply = SmoothingClient(server.address()).smooth({}, {.retry = {.attempts = 1}});
    ASSERT_FALSE(reply.ok());
    EXPECT_EQ(reply.error().retry_after, expected);
  }
}

TEST(RetriedCall, StartsAStreamOverWhenItDiesInTheMiddleOfTheAnswer) {
  std::atomic<int> calls = 0;
  const auto die_at_first = [&](auto& context, SmoothStream& stream) {
    if (++calls > 1) return echo_stream(context, stream);
    receive(stream);
    send_chunk(stream, "half of the ans");
    return grpc::Status(grpc::StatusCode::UNAVAILABLE, "the proxy lost its server");
  };
  const FakeServer server({.smooth_stream = die_at_first});
  Notes notes;
  const auto reply =
      SmoothingClient(server.address()).smooth(small_request(), {.retry = notes.policy(), .unary_bytes = 0});
  ASSERT_TRUE(reply.ok()) << reply.error().message;
  EXPECT_EQ(reply->mesh(), "v 0 0 0");
  EXPECT_EQ(notes.waits.size(), 1u);
}

TEST(RetriedCall, OutlivesItsServer) {
  const TemporaryFolder folder;
  const std::string address = "unix:" + (folder / "socket");
  const auto hang = [](grpc::ServerContext& context, SmoothStream& stream) {
    send_chunk(stream, "half of the ans");
    send_progress(stream, v1::SMOOTH_STAGE_SMOOTH);
    return until_cancelled(context);
  };
  auto server = std::make_unique<FakeServer>(Script{.smooth_stream = hang}, address);
  std::future<void> death;
  CallOptions options;
  options.progress = [&](const v1::SmoothProgress&) {
    death = std::async(std::launch::async, [&] { server->die(); });
  };
  options.retry.wait = [&](milliseconds, const std::stop_token&) {
    death.wait();
    server.reset();  // before the next takes its socket
    server = std::make_unique<FakeServer>(Script{.smooth_stream = echo_stream}, address);
    return true;
  };
  const auto reply = SmoothingClient(address).smooth(small_request(), options);
  ASSERT_TRUE(reply.ok()) << reply.error().message;
  EXPECT_EQ(reply->mesh(), "v 0 0 0");
}

TEST(RetriedCall, FindsAServerThatComesLater) {
  const TemporaryFolder folder;
  const std::string address = "unix:" + (folder / "socket");
  std::optional<FakeServer> server;
  CallOptions options{.timeout = 60s};
  options.retry.attempts = 1000;
  options.retry.initial_delay = 10ms;
  options.retry.longest_delay = 50ms;
  options.retry.jitter = [&] {
    if (!server) server.emplace(Script{.smooth = echo}, address);
    return 0.9;
  };
  const auto reply = SmoothingClient(address).smooth(small_request(), options);
  ASSERT_TRUE(reply.ok()) << reply.error().message;
}

}  // namespace
}  // namespace burnish::client
