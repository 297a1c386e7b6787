// Jobs that outlive their call and their server.
#include "server/jobs/durable_jobs.h"

#include <gtest/gtest.h>

#include <google/protobuf/util/time_util.h>

#include <atomic>
#include <future>
#include <set>

#include "server/jobs/job_states.h"
#include "tests/server/gate.h"
#include "tests/server/jobs_house.h"
#include "tests/support/eventually.h"

namespace burnish {
namespace {

using testing::eventually;
using testing::JobsHouse;

const std::string kMesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
const Caller kAnyone{.transport = Transport::Http};

Submission submission(std::string_view mesh = kMesh) { return {.mesh = {.bytes = mesh}}; }

v1::Job wait_for_end(JobsHouse& house, const std::string& id, const Caller& caller = kAnyone) {
  std::promise<v1::Job> ended;
  auto job = ended.get_future();
  const auto watching = house.durable_jobs.watch(caller, id, [&](const v1::Job& now) {
    if (has_ended(now.state())) ended.set_value(now);
  });
  EXPECT_TRUE(watching);
  return job.get();
}

v1::Job run(JobsHouse& house, const Submission& what) {
  const auto job = house.durable_jobs.submit(kAnyone, what);
  EXPECT_TRUE(job) << job.error().message;
  return wait_for_end(house, job->id());
}

Cause cause_of(const auto& result) { return result ? Cause::Internal : result.error().cause; }

TEST(DurableJobs, GiveTheBytesThatTheServiceGives) {
  JobsHouse house;
  const v1::Job job = run(house, submission());
  ASSERT_EQ(job.state(), v1::JOB_STATE_SUCCEEDED) << job.error().message();
  EXPECT_EQ(job.starts(), 1U);
  EXPECT_EQ(job.report().input().vertices(), 4U);
  EXPECT_EQ(job.report().request_id(), job.id());
  const auto expected = house.service.smooth({.mesh = kMesh}, {});
  const auto result = house.durable_jobs.result(kAnyone, job.id());
  ASSERT_TRUE(result);
  EXPECT_EQ(result->content.bytes, expected->mesh);
  EXPECT_EQ(result->file.sha256(), sha256_of(expected->mesh));
  EXPECT_EQ(result->file.bytes(), expected->mesh.size());
  EXPECT_EQ(result->file.format(), v1::MESH_FORMAT_OBJ);
}

TEST(DurableJobs, FailWithWhatIsWrongWithTheMesh) {
  JobsHouse house;
  const v1::Job job = run(house, submission("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"));
  EXPECT_EQ(job.state(), v1::JOB_STATE_FAILED);
  EXPECT_EQ(job.error().code(), "INDEX_OUT_OF_RANGE");
  EXPECT_NE(job.error().message().find("line 4"), std::string::npos) << job.error().message();
  EXPECT_EQ(cause_of(house.durable_jobs.result(kAnyone, job.id())), Cause::NotReady);
}

TEST(DurableJobs, AreRefusedAtTheDoorForWhatCanBeSeenThere) {
  JobsHouse house({.limits = {.mesh = {.max_bytes = 100}}, .durable = {.max_jobs = 1}});
  DurableJobs& jobs = house.durable_jobs;
  EXPECT_EQ(cause_of(jobs.submit(kAnyone, Submission())), Cause::EmptyMesh);
  Submission wrong = submission();
  wrong.options.set_method("nonsense");
  EXPECT_EQ(cause_of(jobs.submit(kAnyone, wrong)), Cause::UnknownMethod);
  EXPECT_EQ(cause_of(jobs.submit(kAnyone, submission(std::string(101, ' ')))), Cause::TooLarge);
  const auto unknown = jobs.submit(kAnyone, {.mesh = {.sha256 = std::string(64, 'a')}});
  EXPECT_EQ(cause_of(unknown), Cause::NotFound);
  EXPECT_EQ(unknown.error().field, "mesh_sha256");
  EXPECT_EQ(cause_of(jobs.submit(kAnyone, {.mesh = {.sha256 = "xyz"}})), Cause::BadOption);
  EXPECT_EQ(house.store.files->bytes(), 0U) << "what is refused leaves nothing";
}

TEST(DurableJobs, TakeAMeshAgainByItsHash) {
  JobsHouse house;
  const v1::Job first = run(house, submission());
  Submission again;
  again.mesh.sha256 = first.mesh().sha256();
  again.options.set_method("laplacian");
  const v1::Job second = run(house, again);
  EXPECT_EQ(second.state(), v1::JOB_STATE_SUCCEEDED) << second.error().message();
  EXPECT_EQ(second.report().method(), "laplacian");
  EXPECT_EQ(second.mesh().bytes(), kMesh.size());
}

TEST(DurableJobs, ThatAskForTheSameAgainHaveTheirResultAtOnce) {
  JobsHouse house;
  const v1::Job first = run(house, submission());
  const auto again = house.durable_jobs.submit(kAnyone, submission());
  ASSERT_TRUE(again);
  EXPECT_EQ(again->state(), v1::JOB_STATE_SUCCEEDED);
  EXPECT_TRUE(again->from_cache());
  EXPECT_NE(again->id(), first.id());
  EXPECT_EQ(again->report().request_id(), again->id());
  EXPECT_EQ(again->starts(), 0U);
  EXPECT_EQ(house.durable_jobs.result(kAnyone, again->id())->file.sha256(), first.result().sha256());
  Submission other = submission();
  other.options.set_method("laplacian");
  EXPECT_FALSE(house.durable_jobs.submit(kAnyone, other)->from_cache());
  EXPECT_FALSE(house.durable_jobs.submit({.owner = "other"}, submission())->from_cache());
  EXPECT_EQ(house.durable_jobs.cache_hits(), 1U);
  EXPECT_EQ(house.durable_jobs.cache_misses(), 3U);
}

TEST(DurableJobs, BelongToTheirOwner) {
  JobsHouse house;
  const v1::Job job = run(house, submission());
  const Caller stranger{.owner = "stranger"};
  DurableJobs& jobs = house.durable_jobs;
  EXPECT_EQ(cause_of(jobs.get(stranger, job.id())), Cause::NotFound);
  EXPECT_EQ(cause_of(jobs.result(stranger, job.id())), Cause::NotFound);
  EXPECT_EQ(cause_of(jobs.cancel(stranger, job.id())), Cause::NotFound);
  EXPECT_EQ(cause_of(jobs.remove(stranger, job.id())), Cause::NotFound);
  EXPECT_EQ(cause_of(jobs.watch(stranger, job.id(), [](const v1::Job&) {})), Cause::NotFound);
  EXPECT_EQ(jobs.list(stranger, 0, "")->jobs_size(), 0);
  EXPECT_EQ(cause_of(jobs.submit(stranger, {.mesh = {.sha256 = job.mesh().sha256()}})), Cause::NotFound);
  EXPECT_TRUE(jobs.get(kAnyone, job.id()));
}

TEST(DurableJobs, WithTheSameKeyAreTheSameJob) {
  JobsHouse house;
  Submission with_key = submission();
  with_key.idempotency_key = "once";
  const v1::Job first = run(house, with_key);
  EXPECT_EQ(house.durable_jobs.submit(kAnyone, with_key)->id(), first.id());
  with_key.options.set_method("taubin");
  const auto other = house.durable_jobs.submit(kAnyone, with_key);
  EXPECT_EQ(cause_of(other), Cause::IdempotencyKeyReused);
  EXPECT_NE(house.durable_jobs.submit({.owner = "other"}, with_key)->id(), first.id());
  with_key.idempotency_key = "has space";
  EXPECT_EQ(cause_of(house.durable_jobs.submit(kAnyone, with_key)), Cause::BadOption);
}

TEST(DurableJobs, ListNewestFirstPageByPage) {
  JobsHouse house;
  std::vector<std::string> ids;
  for (int i = 0; i < 5; ++i) ids.push_back(house.durable_jobs.submit(kAnyone, submission())->id());
  std::vector<std::string> listed;
  std::string token;
  do {
    const auto page = house.durable_jobs.list(kAnyone, 2, token);
    ASSERT_TRUE(page);
    EXPECT_LE(page->jobs_size(), 2);
    for (const v1::Job& job : page->jobs()) {
      listed.push_back(job.id());
      EXPECT_FALSE(job.has_report());
    }
    token = page->next_page_token();
  } while (!token.empty());
  std::ranges::reverse(listed);
  EXPECT_EQ(listed, ids);
  EXPECT_EQ(cause_of(house.durable_jobs.list(kAnyone, 2, "x")), Cause::BadOption);
  EXPECT_EQ(cause_of(house.durable_jobs.list(kAnyone, 1001, "")), Cause::BadOption);
}

TEST(DurableJobs, StopWhenTheyAreCancelledWhereverTheyAre) {
  testing::Gate gate;
  JobsHouse house({.smooth = gate.smoother()});
  const auto running = house.durable_jobs.submit(kAnyone, submission());
  gate.wait_for(1);
  const auto waiting = house.durable_jobs.submit(kAnyone, submission());
  EXPECT_EQ(house.durable_jobs.get(kAnyone, running->id())->state(), v1::JOB_STATE_RUNNING);
  EXPECT_EQ(house.durable_jobs.get(kAnyone, waiting->id())->state(), v1::JOB_STATE_QUEUED);
  for (const auto* const job : {&waiting, &running}) {
    const auto cancelled = house.durable_jobs.cancel(kAnyone, (*job)->id());
    ASSERT_TRUE(cancelled);
    EXPECT_EQ(cancelled->state(), v1::JOB_STATE_CANCELLED);
  }
  gate.open();
  EXPECT_EQ(house.durable_jobs.cancel(kAnyone, running->id())->state(), v1::JOB_STATE_CANCELLED);
  EXPECT_EQ(run(house, submission()).state(), v1::JOB_STATE_SUCCEEDED) << "the worker is free";
  EXPECT_EQ(house.durable_jobs.get(kAnyone, running->id())->state(), v1::JOB_STATE_CANCELLED);
}

TEST(DurableJobs, AreForgottenWhenRemoved) {
  JobsHouse house;
  const v1::Job job = run(house, submission());
  EXPECT_TRUE(house.durable_jobs.remove(kAnyone, job.id()));
  EXPECT_EQ(cause_of(house.durable_jobs.get(kAnyone, job.id())), Cause::NotFound);
  EXPECT_TRUE(house.durable_jobs.sweep(WallTime::clock::now() + std::chrono::hours(25)));
  EXPECT_EQ(house.store.files->bytes(), 0U);
}

TEST(DurableJobs, ExpireThenAreForgotten) {
  JobsHouse house;
  const v1::Job job = run(house, submission());
  const auto later = [](int hours) { return WallTime::clock::now() + std::chrono::hours(hours); };
  EXPECT_TRUE(house.durable_jobs.sweep(later(23)));
  EXPECT_TRUE(house.durable_jobs.result(kAnyone, job.id()));
  EXPECT_TRUE(house.durable_jobs.sweep(later(25)));
  EXPECT_EQ(cause_of(house.durable_jobs.get(kAnyone, job.id())), Cause::Expired);
  EXPECT_EQ(cause_of(house.durable_jobs.result(kAnyone, job.id())), Cause::Expired);
  EXPECT_EQ(house.durable_jobs.list(kAnyone, 0, "")->jobs(0).state(), v1::JOB_STATE_EXPIRED);
  EXPECT_EQ(house.store.files->bytes(), 0U) << "mesh and result are gone";
  EXPECT_TRUE(house.durable_jobs.sweep(later(24 * 9)));
  EXPECT_EQ(cause_of(house.durable_jobs.get(kAnyone, job.id())), Cause::NotFound);
}

TEST(DurableJobs, OfAServerThatEndedRunInTheNext) {
  const cli::TemporaryFolder folder;
  const std::string store = folder / "store";
  std::vector<std::string> ids;
  {
    testing::Gate gate;
    JobsHouse house({.smooth = gate.smoother(), .store = store});
    for (int i = 0; i < 3; ++i) ids.push_back(house.durable_jobs.submit(kAnyone, submission())->id());
    gate.wait_for(1);
    house.durable_jobs.stop();
    house.lifecycle.move_to(LifecycleState::Draining);
    const auto drained = std::async([&] { house.runner.drain(std::chrono::milliseconds::zero()); });
    EXPECT_TRUE(eventually([&] { return house.durable_jobs.waiting() == 3; })) << "the cut one waits again";
    gate.open();
  }
  JobsHouse house({.store = store});
  for (const std::string& id : ids) {
    const v1::Job job = wait_for_end(house, id);
    EXPECT_EQ(job.state(), v1::JOB_STATE_SUCCEEDED) << job.error().message();
    EXPECT_EQ(job.starts(), 1U) << "a start that the server cut does not count";
  }
}

/// A record as a server leaves it that is killed while the job runs.
TEST(DurableJobs, ThatEndServersAgainAndAgainFail) {
  const cli::TemporaryFolder folder;
  const std::string store = folder / "store";
  std::string id;
  {
    JobsHouse house({.store = store});
    id = run(house, submission()).id();
    house.durable_jobs.stop();
    auto record = **house.store.records->find_job(id);
    record.job.set_state(v1::JOB_STATE_RUNNING);
    record.job.set_starts(5);
    ASSERT_TRUE(house.store.records->update(record));
  }
  JobsHouse house({.store = store});
  const v1::Job job = wait_for_end(house, id);
  EXPECT_EQ(job.state(), v1::JOB_STATE_FAILED);
  EXPECT_EQ(job.error().code(), "INTERNAL");
}

TEST(DurableJobs, ThatFindTheStoreFullFailWithThatCause) {
  JobsHouse house;
  const auto refused = [&](std::uint64_t bytes) {
    const cli::TemporaryFolder folder;
    testing::Store store(folder / "small", bytes);
    DurableJobs jobs(*store.records, *store.files, house.jobs, {});
    return jobs.submit(kAnyone, submission());
  };
  EXPECT_EQ(cause_of(refused(kMesh.size() - 1)), Cause::StorageFull);
  EXPECT_TRUE(refused(kMesh.size()));
}

TEST(DurableJobs, TellTheirWatchersEachChangeAndTheEndLast) {
  JobsHouse house;
  std::mutex mutex;
  std::vector<v1::Job> seen;
  const auto job = house.durable_jobs.submit(kAnyone, submission());
  const auto watching = house.durable_jobs.watch(kAnyone, job->id(), [&](const v1::Job& now) {
    const std::lock_guard lock(mutex);
    seen.push_back(now);
  });
  wait_for_end(house, job->id());
  const std::lock_guard lock(mutex);
  ASSERT_FALSE(seen.empty());
  EXPECT_EQ(seen.back().state(), v1::JOB_STATE_SUCCEEDED);
  for (std::size_t i = 0; i + 1 < seen.size(); ++i) EXPECT_FALSE(has_ended(seen[i].state()));
}

TEST(JobStates, EndForGood) {
  for (const auto from : {v1::JOB_STATE_SUCCEEDED, v1::JOB_STATE_FAILED, v1::JOB_STATE_CANCELLED}) {
    for (int to = v1::JOB_STATE_QUEUED; to <= v1::JOB_STATE_EXPIRED; ++to)
      EXPECT_EQ(may_move(from, static_cast<v1::JobState>(to)), to == v1::JOB_STATE_EXPIRED);
  }
}

TEST(DurableJobs, FailAtTheirDeadlineWhileTheyWait) {
  testing::Gate gate;
  JobsHouse house({.smooth = gate.smoother()});
  const auto running = house.durable_jobs.submit(kAnyone, submission());
  gate.wait_for(1);
  Submission soon = submission();
  soon.timeout = std::chrono::milliseconds(20);
  const auto waiting = house.durable_jobs.submit(kAnyone, soon);
  ASSERT_TRUE(waiting) << waiting.error().message;
  EXPECT_TRUE(waiting->has_deadline());
  const v1::Job late = wait_for_end(house, waiting->id());
  EXPECT_EQ(late.state(), v1::JOB_STATE_FAILED);
  EXPECT_EQ(late.error().code(), "DEADLINE_EXCEEDED");
  EXPECT_EQ(late.starts(), 0U);
  gate.open();
  EXPECT_EQ(wait_for_end(house, running->id()).state(), v1::JOB_STATE_SUCCEEDED);
}

TEST(DurableJobs, FailAtTheirDeadlineWhileTheyRun) {
  testing::Gate gate;
  JobsHouse house({.smooth = gate.smoother()});
  Submission soon = submission();
  soon.timeout = std::chrono::milliseconds(50);
  const auto running = house.durable_jobs.submit(kAnyone, soon);
  ASSERT_TRUE(running);
  EXPECT_EQ(wait_for_end(house, running->id()).error().code(), "DEADLINE_EXCEEDED");
}

TEST(DurableJobs, WhoseDeadlineOutlivesTheServerStillHaveIt) {
  const cli::TemporaryFolder folder;
  const std::string store = folder / "store";
  testing::Gate gate;
  std::string id;
  {
    JobsHouse house({.smooth = gate.smoother(), .store = store});
    EXPECT_TRUE(house.durable_jobs.submit(kAnyone, submission()));
    gate.wait_for(1);
    Submission soon = submission();
    soon.timeout = std::chrono::milliseconds(300);
    id = house.durable_jobs.submit(kAnyone, soon)->id();
    house.durable_jobs.stop();
  }
  JobsHouse house({.smooth = gate.smoother(), .store = store});
  EXPECT_EQ(wait_for_end(house, id).error().code(), "DEADLINE_EXCEEDED");
}

/// A mesh of so many triangles that they are expected to take a while, by the guess before any job ran.
std::string large_mesh() {
  std::string mesh;
  for (int v = 0; v < 30'000; ++v) mesh += "v 0 0 " + std::to_string(v) + "\n";
  for (int t = 0; t < 60'000; ++t) mesh += "f 1 2 3\n";
  return mesh;
}

TEST(DurableJobs, AreRefusedWhenTheJobsAtHandAreExpectedToTakeTooLong) {
  testing::Gate gate;
  JobsHouse house({.smooth = gate.smoother(), .durable = {.max_seconds = std::chrono::seconds(1)}});
  EXPECT_TRUE(house.durable_jobs.submit(kAnyone, submission()));
  gate.wait_for(1);
  const std::string mesh = large_mesh();
  Submission many = submission(mesh);
  many.options.set_method("adaptive");
  many.options.set_iterations(50'000);
  ASSERT_TRUE(house.durable_jobs.submit(kAnyone, many)) << "nothing waits before it";
  const auto refused = house.durable_jobs.submit(kAnyone, submission());
  EXPECT_EQ(cause_of(refused), Cause::QueueFull);
  EXPECT_NE(refused.error().message.find("(jobs-seconds)"), std::string::npos) << refused.error().message;
  EXPECT_GE(refused.error().retry_after, std::chrono::seconds(1));
  EXPECT_GT(house.durable_jobs.look_again_after(), std::chrono::seconds(1));
}

TEST(DurableJobs, AreRefusedWhenTheirDeadlineCannotBeMet) {
  testing::Gate gate;
  JobsHouse house({.smooth = gate.smoother()});
  const std::string mesh = large_mesh();
  Submission hasty = submission(mesh);
  hasty.options.set_method("adaptive");
  hasty.options.set_iterations(50'000);
  hasty.timeout = std::chrono::milliseconds(100);
  const auto refused = house.durable_jobs.submit(kAnyone, hasty);
  EXPECT_EQ(cause_of(refused), Cause::DeadlineExceeded);
  EXPECT_EQ(refused.error().field, "timeout_ms");
  EXPECT_EQ(house.store.files->bytes(), 0U) << "at the door";
  hasty.timeout = std::chrono::hours(1);
  EXPECT_TRUE(house.durable_jobs.submit(kAnyone, hasty));
  hasty.timeout = std::chrono::hours(25);
  EXPECT_EQ(cause_of(house.durable_jobs.submit(kAnyone, hasty)), Cause::BadOption);
  gate.open();
}

TEST(DurableJobs, PayForTheirBytesOnce) {
  const cli::TemporaryFolder folder;
  const auto tokens =
      Tokens::load(
          folder.write("tokens.json", R"({"tokens": [{"name": "a", "bytesPerSecond": 2, "sha256": ")" +
                                          sha256_of("secret") + R"("}]})"))
          .value();
  ASSERT_LT(kMesh.size(), 120U) << "a minute's worth";
  ASSERT_GT(2 * kMesh.size(), 120U);
  JobsHouse house;
  house.jobs.ask_for(tokens.get());
  const Caller owner{.owner = "a"};
  const auto job = house.durable_jobs.submit(owner, submission());
  ASSERT_TRUE(job) << job.error().message;
  EXPECT_EQ(wait_for_end(house, job->id(), owner).state(), v1::JOB_STATE_SUCCEEDED);
}

TEST(FairLine, TakesNormalBeforeLowAndOwnersInTurn) {
  FairLine<std::string> line;
  for (const char* id : {"a1", "a2", "a3"}) line.push_back({"a"}, id);
  line.push_back({"c", true}, "c1");
  for (const char* id : {"b1", "b2"}) line.push_back({"b"}, id);
  EXPECT_TRUE(line.remove({"a"}, "a2"));
  EXPECT_FALSE(line.remove({"a"}, "a2"));
  EXPECT_EQ(line.size(), 5U);
  const auto before = [&](const Turn& turn) {
    std::set<std::string> ids;
    line.for_each_before(turn, [&](const std::string& id) { ids.insert(id); });
    return ids;
  };
  EXPECT_EQ(before({"d"}), (std::set<std::string>{"a1", "b1"}));
  EXPECT_EQ(before({"a"}), (std::set<std::string>{"a1", "a3", "b1", "b2"}));
  EXPECT_EQ(before({"d", true}), (std::set<std::string>{"a1", "a3", "b1", "b2", "c1"}));
  std::vector<std::string> order;
  while (const auto id = line.pop()) order.push_back(*id);
  EXPECT_EQ(order, (std::vector<std::string>{"a1", "b1", "a3", "b2", "c1"}));
}

}  // namespace
}  // namespace burnish
