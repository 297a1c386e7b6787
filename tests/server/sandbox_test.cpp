// Helper processes. This program is its own helper, with a smoother that misbehaves when it is asked to.
#include "server/sandbox/sandbox.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <future>
#include <thread>

#include "server/jobs/spool.h"
#include "server/mapped_files.h"
#include "server/sandbox/helper.h"
#include "tests/support/eventually.h"

namespace burnish {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using Clock = RunControl::Clock;

const std::string kMesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

/// What a helper that was taken over would try, by name; "errno" of each in the result.
std::string attempts() {
  std::string told;
  const auto tell = [&](const char* what, long result) {
    told += std::string(what) + "=" + (result < 0 ? std::to_string(errno) : "done") + "\n";
  };
  tell("open", ::open("/etc/hostname", O_RDONLY | O_CLOEXEC));
  tell("create", ::open("/tmp/burnish-sandbox-test", O_WRONLY | O_CREAT | O_CLOEXEC, 0600));
  tell("socket", ::socket(AF_INET, SOCK_STREAM, 0));
  tell("kill", ::kill(::getppid(), 0));
  tell("code", ::mmap(nullptr, 4096, PROT_READ | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) == MAP_FAILED
                   ? -1
                   : 0);
  tell("fork", ::fork());
  char* const arguments[] = {nullptr};
  tell("exec", ::execve("/bin/true", arguments, arguments));
  tell("files", ::fcntl(16, F_GETFD));
  return told;
}

Result<SmoothResult> misbehave(const SmoothJob& job, const RunControl& run) {
  const std::string& how = job.request_id;
  SmoothResult result{.mesh = "", .format = Format::Obj, .report = {}};
  if (how == "crash") std::abort();
  if (how == "exit") ::_exit(7);
  if (how == "attempts") result.mesh = attempts();
  if (how == "environment") {
    result.mesh = std::getenv("HOME") ? "HOME" : "";
    if (const char* tunables = std::getenv("GLIBC_TUNABLES")) result.mesh += tunables;
  }
  if (how == "throw") throw std::runtime_error("on purpose");
  if (how == "hungry") result.mesh.resize(std::size_t{1} << 30, 'x');
  if (how == "threads") {
    std::thread([&] { result.mesh = "a thread"; }).join();
  }
  if (job.progress) job.progress(v1::SMOOTH_STAGE_SMOOTH, 0);
  while (how == "deaf") std::this_thread::yield();
  while (how == "waits" && !run.stopped()) std::this_thread::yield();
  if (how == "waits") return run.stop_error();
  if (how == "late") result.mesh.resize(std::size_t{8} << 20, 'x');
  while (how == "late" && !run.stopped()) std::this_thread::yield();
  if (!result.mesh.empty()) return result;
  return SmoothService().smooth(job, run);
}

std::unique_ptr<Sandbox> sandbox_of(unsigned helpers = 1, std::uint64_t max_memory = 0) {
  auto started = Sandbox::start(
      {.program = "/proc/self/exe", .helpers = helpers, .max_memory = max_memory, .patience = 100ms});
  EXPECT_TRUE(started) << started.error().message;
  return std::move(started).value();
}

Result<SmoothResult> ask(Sandbox& sandbox, const std::string& how, const RunControl& run = {}) {
  return sandbox.smooth({.mesh = kMesh, .request_id = how}, run);
}

/// Cancels when the helper says that it has begun.
Result<SmoothResult> ask_and_cancel(Sandbox& sandbox, const std::string& how) {
  std::stop_source stop;
  return sandbox.smooth(
      {.mesh = kMesh, .request_id = how, .progress = [&](v1::SmoothStage, double) { stop.request_stop(); }},
      {.stop = stop.get_token()});
}

TEST(Sandbox, GivesTheBytesOfTheService) {
  const auto sandbox = sandbox_of();
  SmoothJob job{.mesh = kMesh, .request_id = "the same"};
  for (const char* const method : {"laplacian", "adaptive", "auto"}) {
    job.options.set_method(method);
    const auto here = SmoothService().smooth(job, {}), there = sandbox->smooth(job, {});
    ASSERT_TRUE(there) << there.error().message;
    EXPECT_EQ(there->mesh, here->mesh);
    EXPECT_EQ(there->format, here->format);
    EXPECT_EQ(there->report.request_id(), "the same");
    EXPECT_EQ(there->report.errors().SerializeAsString(), here->report.errors().SerializeAsString());
  }
}

TEST(Sandbox, GivesDracoAndReferencesAsTheServiceDoes) {
  const auto sandbox = sandbox_of();
  SmoothJob job{.mesh = kMesh, .format = Format::Obj, .reference = kMesh, .reference_format = Format::Obj};
  job.options.mutable_output()->set_format(v1::MESH_FORMAT_DRACO);
  const auto here = SmoothService().smooth(job, {}), there = sandbox->smooth(job, {.threads = 0});
  ASSERT_TRUE(there) << there.error().message;
  EXPECT_EQ(there->mesh, here->mesh);
  EXPECT_EQ(there->format, Format::Draco);
  EXPECT_EQ(there->report.errors().against(), "reference");
}

TEST(Sandbox, ComparesAsTheServiceDoes) {
  const auto sandbox = sandbox_of();
  const CompareJob job{.reference = kMesh, .mesh = kMesh};
  const auto here = SmoothService().compare(job, {}), there = sandbox->compare(job, {});
  ASSERT_TRUE(there) << there.error().message;
  EXPECT_EQ(there->errors().SerializeAsString(), here->errors().SerializeAsString());
  const auto wrong = sandbox->compare({.reference = kMesh, .mesh = "v 0 0 0\nf 1 2 3\n"}, {});
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().message, HasSubstr("mesh: "));
}

TEST(Sandbox, KeepsBothMeshesInPlaceWhenItsBufferGrows) {
  const auto sandbox = sandbox_of();
  ASSERT_TRUE(ask(*sandbox, "small"));
  std::string large;
  while (large.size() < std::size_t{9} << 20) large += "# a comment that makes the mesh large\n";
  large += kMesh;
  for (int i = 0; i < 2; ++i) {  // and again, when the buffer has been tidied
    const SmoothJob job{.mesh = kMesh, .reference = large};
    const auto here = SmoothService().smooth(job, {}), there = sandbox->smooth(job, {});
    ASSERT_TRUE(there) << there.error().message;
    EXPECT_EQ(there->mesh, here->mesh);
  }
}

TEST(Sandbox, PassesErrorsOnAsTheyAre) {
  const auto sandbox = sandbox_of();
  const SmoothJob job{.mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"};
  const auto here = SmoothService().smooth(job, {}), there = sandbox->smooth(job, {});
  ASSERT_FALSE(there);
  EXPECT_EQ(there.error(), here.error());
}

TEST(Sandbox, TakesMeshesInFilesFromWhereTheyAre) {
  const auto sandbox = sandbox_of();
  std::string large = "# first\n";
  while (large.size() < std::size_t{3} << 20)
    large += "# a comment that makes the file long enough to be one\n";
  Spool spool;
  const auto body = spool.body();
  ASSERT_TRUE(body->append("another part"));
  ASSERT_TRUE(body->append(large + kMesh));
  const std::string_view mesh = body->finish()->substr(12);
  ASSERT_TRUE(MappedFile::holding(mesh));
  EXPECT_EQ(MappedFile::holding(mesh)->offset, 12U);
  const SmoothJob job{.mesh = mesh, .reference = kMesh};
  const auto here = SmoothService().smooth(job, {}), there = sandbox->smooth(job, {});
  ASSERT_TRUE(there) << there.error().message;
  EXPECT_EQ(there->mesh, here->mesh);
}

TEST(Sandbox, TellsHowTheJobGoes) {
  const auto sandbox = sandbox_of();
  std::vector<v1::SmoothStage> stages;
  SmoothJob job{.mesh = kMesh};
  job.progress = [&](v1::SmoothStage stage, double fraction) {
    if (fraction == 0) stages.push_back(stage);
  };
  ASSERT_TRUE(sandbox->smooth(job, {}));
  EXPECT_THAT(stages, ::testing::IsSupersetOf({v1::SMOOTH_STAGE_DECODE, v1::SMOOTH_STAGE_SMOOTH,
                                               v1::SMOOTH_STAGE_MEASURE, v1::SMOOTH_STAGE_ENCODE}));
}

TEST(Sandbox, CanDoNothingButCompute) {
  const auto sandbox = sandbox_of();
  const auto told = ask(*sandbox, "attempts");
  ASSERT_TRUE(told) << told.error().message;
  for (const char* const what : {"open", "create", "socket", "kill", "code", "fork", "exec"})
    EXPECT_THAT(told->mesh, HasSubstr(std::string(what) + "=" + std::to_string(EPERM) + "\n"));
  EXPECT_THAT(told->mesh, HasSubstr("files=")) << "and has no file of this process";
  EXPECT_THAT(told->mesh, ::testing::Not(HasSubstr("done")));
  EXPECT_EQ(ask(*sandbox, "environment")->mesh, "glibc.malloc.hugetlb=1");
  EXPECT_EQ(ask(*sandbox, "threads")->mesh, "a thread");
}

TEST(Sandbox, SurvivesHelpersThatEnd) {
  const auto sandbox = sandbox_of();
  const auto first = sandbox->helper_ids();
  const auto crashed = ask(*sandbox, "crash");
  ASSERT_FALSE(crashed);
  EXPECT_EQ(crashed.error().cause, Cause::Internal);
  EXPECT_THAT(crashed.error().message, HasSubstr("signal 6"));
  EXPECT_THAT(ask(*sandbox, "exit").error().message, HasSubstr("exit 7"));
  EXPECT_TRUE(ask(*sandbox, "well")) << "there is a new one";
  EXPECT_NE(sandbox->helper_ids(), first);
  EXPECT_EQ(sandbox->helper_ids().size(), 1U);
  EXPECT_EQ(sandbox->ended_helpers(), 2U);
  EXPECT_THAT(ask(*sandbox, "throw").error().message, HasSubstr("on purpose"));
  EXPECT_EQ(sandbox->ended_helpers(), 2U) << "an exception ends no helper";
}

TEST(Sandbox, DoesNotBlameAJobForAHelperThatEndedBefore) {
  const auto sandbox = sandbox_of();
  const pid_t id = sandbox->helper_ids().front();
  ::kill(id, SIGKILL);
  EXPECT_TRUE(testing::eventually([&] { return sandbox->resident_bytes() == 0; }))
      << "a zombie has no memory";
  EXPECT_TRUE(ask(*sandbox, "well"));
}

TEST(Sandbox, SaysThatMemoryWasShortWhenTheSystemKilledTheHelper) {
  const auto sandbox = sandbox_of();
  auto job = std::async(std::launch::async, [&] { return ask(*sandbox, "deaf"); });
  EXPECT_TRUE(testing::eventually([&] {  // until it was killed while it worked
    for (const int id : sandbox->helper_ids()) ::kill(id, SIGKILL);
    return job.wait_for(1ms) == std::future_status::ready;
  }));
  EXPECT_EQ(job.get().error().cause, Cause::OutOfMemory);
}

TEST(Sandbox, StopsAJobThatIsCancelledOrLate) {
  const auto sandbox = sandbox_of();
  std::stop_source stop;
  auto job =
      std::async(std::launch::async, [&] { return ask(*sandbox, "waits", {.stop = stop.get_token()}); });
  stop.request_stop();
  EXPECT_EQ(job.get().error().cause, Cause::Cancelled);
  EXPECT_EQ(ask(*sandbox, "waits", {.deadline = Clock::now() + 20ms}).error().cause, Cause::DeadlineExceeded);
  EXPECT_EQ(sandbox->ended_helpers(), 0U);
}

TEST(Sandbox, HearsACancelWhileAResultIsHandedOver) {
  const auto sandbox = sandbox_of();
  EXPECT_EQ(ask_and_cancel(*sandbox, "late").error().cause, Cause::Cancelled);
  EXPECT_EQ(sandbox->ended_helpers(), 0U);
}

TEST(Sandbox, GivesNoMeshToAHelperWhenTheCallerIsGone) {
  std::stop_source stop;
  stop.request_stop();
  const auto sandbox = sandbox_of();
  EXPECT_EQ(ask(*sandbox, "crash", {.stop = stop.get_token()}).error().cause, Cause::Cancelled);
  EXPECT_EQ(sandbox->ended_helpers(), 0U);
}

TEST(Sandbox, KillsAHelperThatDoesNotStop) {
  const auto sandbox = sandbox_of();
  EXPECT_EQ(ask_and_cancel(*sandbox, "deaf").error().cause, Cause::Cancelled);
  EXPECT_EQ(sandbox->ended_helpers(), 1U);
  EXPECT_TRUE(ask(*sandbox, "well"));
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(_GLIBCXX_TSAN)  // see cmake/compiler.cmake
TEST(Sandbox, BoundsTheMemoryOfAHelper) {
  const auto sandbox = sandbox_of(1, std::uint64_t{256} << 20);
  const auto hungry = ask(*sandbox, "hungry");
  ASSERT_FALSE(hungry);
  EXPECT_EQ(hungry.error().cause, Cause::OutOfMemory);
  EXPECT_EQ(sandbox->ended_helpers(), 0U);
  EXPECT_TRUE(ask(*sandbox, "well"));
}
#endif

TEST(Sandbox, ServesManyThreads) {
  const auto sandbox = sandbox_of(2);
  const std::string expected = SmoothService().smooth({.mesh = kMesh}, {})->mesh;
  std::vector<std::jthread> callers;
  std::atomic<int> right = 0;
  for (int t = 0; t < 4; ++t) {
    callers.emplace_back([&] {
      for (int i = 0; i < 25; ++i) {
        if (i % 10 == 9) static_cast<void>(ask(*sandbox, "crash"));
        const auto result = ask(*sandbox, "well");
        if (result && result->mesh == expected) ++right;
      }
    });
  }
  callers.clear();
  EXPECT_EQ(right, 100);
  EXPECT_EQ(sandbox->ended_helpers(), 8U);
}

TEST(Sandbox, SaysWhyItDoesNotStart) {
  const auto missing = Sandbox::start({.program = "/nonexistent/program"});
  ASSERT_FALSE(missing);
  EXPECT_THAT(missing.error().message, HasSubstr("No such file"));
  const auto other = Sandbox::start({.program = "/bin/false"});
  ASSERT_FALSE(other);
  EXPECT_THAT(other.error().message, HasSubstr("exit 1"));
}

}  // namespace
}  // namespace burnish

int main(int argc, char** argv) {
  if (argc == 2 && std::string_view(argv[1]) == burnish::kHelperArgument)
    return burnish::run_helper(burnish::misbehave);
  ::testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
