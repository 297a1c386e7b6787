// Meshes that come in pieces.
#include "server/jobs/uploads.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "tests/server/jobs_house.h"

namespace burnish {
namespace {

using testing::JobsHouse;

const std::string kMesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
const Caller kAnyone;

Cause cause_of(const auto& result) { return result ? Cause::Internal : result.error().cause; }

/// Appends and ends the append well; the upload as it is then.
Result<v1::Upload> append(Uploads& uploads, const std::string& id, std::uint64_t offset,
                          std::string_view bytes, bool last = false) {
  auto open = uploads.append(kAnyone, id, offset);
  if (!open) return std::move(open).error();
  if (auto written = (*open)->write(bytes); !written) return std::move(written).error();
  return (*open)->finish(last);
}

TEST(Uploads, BecomeMeshesThatJobsName) {
  JobsHouse house;
  const auto made = house.uploads.create(kAnyone, 0, "");
  ASSERT_TRUE(made);
  EXPECT_EQ(append(house.uploads, made->id(), 0, kMesh.substr(0, 10))->offset(), 10U);
  const auto done = append(house.uploads, made->id(), 10, kMesh.substr(10), true);
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_TRUE(done->complete());
  EXPECT_EQ(done->sha256(), sha256_of(kMesh));
  EXPECT_EQ(done->bytes(), kMesh.size());
  EXPECT_TRUE(house.durable_jobs.submit(kAnyone, {.mesh = {.sha256 = done->sha256()}}));
}

TEST(Uploads, AreCompleteWhenTheyHaveTheirLength) {
  JobsHouse house;
  const auto made = house.uploads.create(kAnyone, kMesh.size(), "");
  EXPECT_TRUE(append(house.uploads, made->id(), 0, kMesh)->complete());
  EXPECT_EQ(cause_of(append(house.uploads, made->id(), kMesh.size(), "x")), Cause::UploadOffsetMismatch);
}

TEST(Uploads, OfAMeshThatIsThereNeedNoBytes) {
  JobsHouse house;
  const auto first = house.uploads.create(kAnyone, kMesh.size(), "");
  ASSERT_TRUE(append(house.uploads, first->id(), 0, kMesh));
  const auto again = house.uploads.create(kAnyone, 0, sha256_of(kMesh));
  EXPECT_TRUE(again->complete());
  EXPECT_EQ(again->offset(), kMesh.size());
  EXPECT_FALSE(house.uploads.create({.owner = "stranger"}, 0, sha256_of(kMesh))->complete())
      << "or strangers could ask which meshes there are";
}

TEST(Uploads, KeepWhatCameBeforeTheConnectionBroke) {
  JobsHouse house;
  const auto made = house.uploads.create(kAnyone, kMesh.size(), sha256_of(kMesh));
  {
    const auto open = std::move(house.uploads.append(kAnyone, made->id(), 0).value());
    EXPECT_TRUE(open->write(kMesh.substr(0, 30)));
  }
  EXPECT_EQ(house.uploads.get(kAnyone, made->id())->offset(), 30U);
  EXPECT_EQ(cause_of(append(house.uploads, made->id(), 29, "x")), Cause::UploadOffsetMismatch);
  EXPECT_TRUE(append(house.uploads, made->id(), 30, kMesh.substr(30))->complete());
}

/// The connection of a client that lost its network looks alive for a while.
TEST(Uploads, GoToTheNextRequestWhileADeadConnectionHoldsThem) {
  JobsHouse house;
  const auto made = house.uploads.create(kAnyone, 0, sha256_of(kMesh));
  auto dead = std::move(house.uploads.append(kAnyone, made->id(), 0).value());
  ASSERT_TRUE(dead->write(kMesh.substr(0, 30)));
  EXPECT_EQ(cause_of(house.uploads.append(kAnyone, made->id(), 0)), Cause::UploadOffsetMismatch);
  ASSERT_TRUE(dead->write(kMesh.substr(30, 10))) << "and still holds it";
  const auto next = house.uploads.append(kAnyone, made->id(), 40);
  ASSERT_TRUE(next) << next.error().message;
  EXPECT_EQ(cause_of(dead->write("x")), Cause::NotReady);
  EXPECT_EQ(cause_of(dead->finish(true)), Cause::NotReady);
  ASSERT_TRUE((*next)->write(kMesh.substr(40)));
  dead.reset();
  EXPECT_EQ((*next)->finish(true)->sha256(), sha256_of(kMesh));
}

TEST(Uploads, HaveOneWriterHoweverManyTakeThemOver) {
  JobsHouse house;
  const auto made = house.uploads.create(kAnyone, 0, "");
  std::vector<std::jthread> clients;
  for (int client = 0; client < 4; ++client) {
    clients.emplace_back([&] {
      for (std::uint64_t at = 0; at < kMesh.size();) {
        at = house.uploads.get(kAnyone, made->id())->offset();
        const auto open = house.uploads.append(kAnyone, made->id(), at);
        for (; open && at < kMesh.size(); ++at) {
          if (!(*open)->write(kMesh.substr(at, 1))) break;
        }
      }
    });
  }
  clients.clear();
  EXPECT_EQ(append(house.uploads, made->id(), kMesh.size(), "", true)->sha256(), sha256_of(kMesh));
}

TEST(Uploads, AreRemovedWhileBytesCome) {
  JobsHouse house;
  const auto made = house.uploads.create(kAnyone, 0, "");
  const auto open = std::move(house.uploads.append(kAnyone, made->id(), 0).value());
  ASSERT_TRUE(open->write(kMesh));
  EXPECT_TRUE(house.uploads.remove(kAnyone, made->id()));
  EXPECT_EQ(cause_of(open->write("x")), Cause::NotReady);
  EXPECT_EQ(house.store.files->bytes(), 0U);
}

TEST(Uploads, GoOnInTheNextServer) {
  const cli::TemporaryFolder folder;
  const std::string store = folder / "store";
  std::string id;
  {
    JobsHouse house({.store = store});
    id = house.uploads.create(kAnyone, kMesh.size(), "")->id();
    ASSERT_TRUE(append(house.uploads, id, 0, kMesh.substr(0, 30)));
    // As a server leaves it that is killed while bytes come: more in the file than was promised.
    ASSERT_TRUE(house.store.files->write_part(id, 30, "torn"));
  }
  JobsHouse house({.store = store});
  EXPECT_EQ(house.uploads.get(kAnyone, id)->offset(), 30U);
  EXPECT_EQ(append(house.uploads, id, 30, kMesh.substr(30))->sha256(), sha256_of(kMesh));
}

TEST(Uploads, RefuseOtherBytesThanWereAnnounced) {
  JobsHouse house;
  const auto wrong = house.uploads.create(kAnyone, 0, sha256_of("another"));
  EXPECT_EQ(cause_of(append(house.uploads, wrong->id(), 0, kMesh, true)), Cause::UploadCorrupt);
  EXPECT_EQ(cause_of(house.uploads.get(kAnyone, wrong->id())), Cause::NotFound);
  const auto longer = house.uploads.create(kAnyone, 10, "");
  EXPECT_EQ(cause_of(append(house.uploads, longer->id(), 0, kMesh)), Cause::TooLarge);
  const auto shorter = house.uploads.create(kAnyone, 10, "");
  EXPECT_EQ(cause_of(append(house.uploads, shorter->id(), 0, "v 0", true)), Cause::BadRequest);
  EXPECT_EQ(house.uploads.get(kAnyone, shorter->id())->offset(), 3U) << "and can go on";
  const auto empty = house.uploads.create(kAnyone, 0, "");
  EXPECT_EQ(cause_of(append(house.uploads, empty->id(), 0, "", true)), Cause::EmptyMesh);
  EXPECT_EQ(cause_of(house.uploads.create(kAnyone, std::uint64_t{1} << 40, "")), Cause::TooLarge);
  EXPECT_EQ(cause_of(house.uploads.create(kAnyone, 0, "abc")), Cause::BadOption);
}

TEST(Uploads, BelongToTheirOwner) {
  JobsHouse house;
  const auto made = house.uploads.create(kAnyone, 0, "");
  const Caller stranger{.owner = "stranger"};
  EXPECT_EQ(cause_of(house.uploads.get(stranger, made->id())), Cause::NotFound);
  EXPECT_EQ(cause_of(house.uploads.append(stranger, made->id(), 0)), Cause::NotFound);
  EXPECT_EQ(cause_of(house.uploads.remove(stranger, made->id())), Cause::NotFound);
  EXPECT_TRUE(house.uploads.get(kAnyone, made->id()));
}

TEST(Uploads, AreForgottenWithTheirBytes) {
  JobsHouse house;
  for (const bool removed : {true, false}) {
    const auto made = house.uploads.create(kAnyone, 0, "");
    ASSERT_TRUE(append(house.uploads, made->id(), 0, kMesh));
    EXPECT_EQ(house.store.files->bytes(), kMesh.size());
    if (removed) {
      EXPECT_TRUE(house.uploads.remove(kAnyone, made->id()));
    } else {
      house.uploads.sweep(WallTime::clock::now() + std::chrono::hours(25));
    }
    EXPECT_EQ(cause_of(house.uploads.get(kAnyone, made->id())), Cause::NotFound);
    EXPECT_EQ(house.store.files->bytes(), 0U);
  }
}

}  // namespace
}  // namespace burnish
