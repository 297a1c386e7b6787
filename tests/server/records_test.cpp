// What a server remembers across its ends.
#include "server/store/records.h"

#include <gtest/gtest.h>

#include <sqlite3.h>

#include "server/store/sqlite_records.h"
#include "tests/client/temporary_folder.h"

namespace burnish {
namespace {

using cli::TemporaryFolder;
using std::chrono::milliseconds;

WallTime at(int time) { return WallTime(std::chrono::seconds(time)); }

std::unique_ptr<Records> open(const TemporaryFolder& folder) {
  return std::move(open_sqlite_records(folder / "records.sqlite").value());
}

JobRecord record(const std::string& id, const std::string& owner = "me", const std::string& key = "") {
  JobRecord result;
  result.job.set_id(id);
  result.job.set_state(v1::JOB_STATE_QUEUED);
  result.job.mutable_mesh()->set_sha256("mesh-of-" + id);
  (*result.job.mutable_options()->mutable_parameters())["x"].set_string_value(std::string("a\0b", 3));
  result.owner = owner;
  result.idempotency_key = key;
  result.request_hash = "hash-of-" + id;
  result.transport = "grpc";
  result.trace_id = "trace";
  return result;
}

std::vector<std::string> ids(const Result<std::vector<JobRecord>>& records) {
  std::vector<std::string> result;
  for (const JobRecord& each : *records) result.push_back(each.job.id());
  return result;
}
using Ids = std::vector<std::string>;

TEST(Records, ComeBackAsTheyWereInTheNextServer) {
  const TemporaryFolder folder;
  JobRecord first = record("1", "me", "key");
  {
    const auto records = open(folder);
    ASSERT_TRUE(records->add(first, at(100)));
    first.job.set_state(v1::JOB_STATE_SUCCEEDED);
    first.expires = at(50);
    ASSERT_TRUE(records->update(first));
  }
  const auto records = open(folder);
  const auto found = records->find_job("1");
  ASSERT_TRUE(found && *found);
  EXPECT_EQ((*found)->job.SerializeAsString(), first.job.SerializeAsString());
  EXPECT_EQ((*found)->sequence, first.sequence);
  EXPECT_EQ((*found)->owner, "me");
  EXPECT_EQ((*found)->transport, "grpc");
  EXPECT_EQ((*found)->trace_id, "trace");
  EXPECT_EQ((*found)->request_hash, "hash-of-1");
  EXPECT_EQ((*found)->expires, at(50));
  EXPECT_EQ((*records->find_by_key("me", "key"))->job.id(), "1");
  EXPECT_FALSE(*records->find_by_key("other", "key"));
  EXPECT_FALSE(*records->find_by_key("me", ""));
  EXPECT_FALSE(*records->find_job("2"));
}

TEST(Records, HaveNoTwoJobsOfOneIdOrKey) {
  const TemporaryFolder folder;
  const auto records = open(folder);
  JobRecord first = record("1", "me", "key"), same_id = record("1"), same_key = record("2", "me", "key"),
            other = record("3", "other", "key");
  EXPECT_TRUE(records->add(first, at(100)));
  EXPECT_FALSE(records->add(same_id, at(100)));
  EXPECT_FALSE(records->add(same_key, at(100)));
  EXPECT_TRUE(records->add(other, at(100)));
  EXPECT_FALSE(*records->has_mesh("me", "mesh-of-2")) << "all of a job or nothing";
}

TEST(Records, KnowWhoseJobsThereAreAndWhichHaveNotEnded) {
  const TemporaryFolder folder;
  const auto records = open(folder);
  for (const char* id : {"1", "2", "3", "4"}) {
    JobRecord job = record(id, id == std::string("2") ? "other" : "me");
    ASSERT_TRUE(records->add(job, at(100)));
    if (id == std::string("3")) {
      job.job.set_state(v1::JOB_STATE_FAILED);
      job.expires = at(10);
      ASSERT_TRUE(records->update(job));
    }
  }
  EXPECT_EQ(ids(records->unfinished()), (Ids{"1", "2", "4"}));
  EXPECT_EQ(ids(records->list("me", 1000, 2)), (Ids{"4", "3"}));
  EXPECT_EQ(ids(records->list("me", 3, 2)), (Ids{"1"}));
  EXPECT_EQ(ids(records->expired(at(9), 10)), Ids{});
  EXPECT_EQ(ids(records->expired(at(10), 10)), Ids{"3"});
  ASSERT_TRUE(records->remove_job("3"));
  EXPECT_EQ(ids(records->expired(at(10), 10)), Ids{});
}

TEST(Records, TellWhichFilesAreNeeded) {
  const TemporaryFolder folder;
  const auto records = open(folder);
  JobRecord job = record("1");
  job.job.mutable_reference()->set_sha256("reference");
  ASSERT_TRUE(records->add(job, at(100)));
  ASSERT_TRUE(records->remove_expired_meshes(at(1000)));
  EXPECT_TRUE(records->files_in_use()->contains("mesh-of-1")) << "of a job that has not ended";
  EXPECT_TRUE(records->files_in_use()->contains("reference"));
  job.job.set_state(v1::JOB_STATE_SUCCEEDED);
  job.job.mutable_result()->set_sha256("result");
  ASSERT_TRUE(records->update(job));
  EXPECT_FALSE(records->files_in_use()->contains("mesh-of-1"));
  EXPECT_TRUE(records->files_in_use()->contains("result"));
  ASSERT_TRUE(records->put(MeshRecord{"me", "mesh", at(10)}));
  ASSERT_TRUE(records->put(MeshRecord{"me", "mesh", at(5)}));
  ASSERT_TRUE(records->remove_expired_meshes(at(9)));
  EXPECT_TRUE(*records->has_mesh("me", "mesh")) << "the longer time counts";
  EXPECT_FALSE(*records->has_mesh("other", "mesh"));
}

TEST(Records, KeepUploads) {
  const TemporaryFolder folder;
  UploadRecord upload{.owner = "me", .expires = at(7)};
  upload.upload.set_id("u");
  {
    const auto records = open(folder);
    ASSERT_TRUE(records->put(upload));
    upload.upload.set_offset(12);
    ASSERT_TRUE(records->put(upload));
  }
  const auto records = open(folder);
  ASSERT_EQ(records->uploads()->size(), 1U);
  EXPECT_EQ(records->uploads()->front().upload.offset(), 12U);
  EXPECT_EQ(records->uploads()->front().owner, "me");
  EXPECT_EQ(records->uploads()->front().expires, at(7));
  ASSERT_TRUE(records->remove_upload("u"));
  EXPECT_TRUE(records->uploads()->empty());
}

TEST(Records, RefuseAFileThatIsNoneOrOfALaterServer) {
  const TemporaryFolder folder;
  EXPECT_EQ(open_sqlite_records(folder.write("text", std::string(1000, 'x'))).error().cause,
            Cause::BadOption);
  EXPECT_EQ(open_sqlite_records(folder / "none/records").error().cause, Cause::BadOption);
  { open(folder); }
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open((folder / "records.sqlite").c_str(), &database), SQLITE_OK);
  sqlite3_exec(database, "PRAGMA user_version = 99", nullptr, nullptr, nullptr);
  sqlite3_close(database);
  const auto later = open_sqlite_records(folder / "records.sqlite");
  ASSERT_FALSE(later);
  EXPECT_NE(later.error().message.find("later version"), std::string::npos) << later.error().message;
}

}  // namespace
}  // namespace burnish
