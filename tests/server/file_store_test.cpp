// Files that are whole or not there.
#include "server/store/file_store.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <thread>
#include <vector>

#include "tests/client/temporary_folder.h"

namespace burnish {
namespace {

using cli::TemporaryFolder;

std::unique_ptr<FileStore> open(const TemporaryFolder& folder, std::uint64_t max_bytes = 1000) {
  return std::move(FileStore::open({.folder = folder / "store", .max_bytes = max_bytes}).value());
}

Cause cause_of(const auto& result) { return result ? Cause::Internal : result.error().cause; }

std::size_t files_below(const std::string& folder) {
  std::size_t files = 0;
  for (const auto& each : std::filesystem::recursive_directory_iterator(folder))
    files += each.is_regular_file();
  return files;
}

TEST(Sha256, IsTheOneOfTheStandard) {
  EXPECT_EQ(sha256_of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256_of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  const std::string million(1'000'000, 'a');
  EXPECT_EQ(sha256_of(million), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  EXPECT_EQ(*parse_sha256(std::string(64, 'A'), "x"), std::string(64, 'a'));
  for (const std::string& wrong :
       {std::string(), std::string(63, 'a'), std::string(65, 'a'), std::string(64, 'g')}) {
    const auto parsed = parse_sha256(wrong, "mesh_sha256");
    ASSERT_FALSE(parsed);
    EXPECT_EQ(parsed.error().field, "mesh_sha256");
  }
}

TEST(FileStore, KeepsBytesAcrossItsLives) {
  const TemporaryFolder folder;
  const std::string sha256 = sha256_of("mesh");
  {
    const auto store = open(folder);
    EXPECT_FALSE(store->has(sha256));
    EXPECT_EQ(cause_of(store->map(sha256)), Cause::NotFound);
    ASSERT_TRUE(store->put("mesh", sha256));
    ASSERT_TRUE(store->put("mesh", sha256)) << "again";
    EXPECT_EQ(store->bytes(), 4U);
  }
  const auto store = open(folder);
  EXPECT_EQ(store->map(sha256)->bytes, "mesh");
  EXPECT_EQ(store->bytes(), 4U);
}

TEST(FileStore, IsOneServersAlone) {
  const TemporaryFolder folder;
  const auto first = open(folder);
  const auto second = FileStore::open({.folder = folder / "store"});
  EXPECT_EQ(cause_of(second), Cause::BadOption);
  EXPECT_NE(second.error().message.find("another server"), std::string::npos) << second.error().message;
  EXPECT_EQ(cause_of(FileStore::open({.folder = folder.write("file", "x")})), Cause::BadOption);
}

TEST(FileStore, LeavesNothingHalfWritten) {
  const TemporaryFolder folder;
  { open(folder); }
  folder.write("store/temporary/0", "half a mesh");
  const auto store = open(folder);
  EXPECT_EQ(files_below(folder / "store/temporary"), 0U);
  EXPECT_EQ(store->bytes(), 0U);
}

TEST(FileStore, RefusesMoreThanItMayHold) {
  const TemporaryFolder folder;
  const auto store = open(folder, 10);
  ASSERT_TRUE(store->put("12345678", sha256_of("12345678")));
  const auto full = store->put("abc", sha256_of("abc"));
  EXPECT_EQ(cause_of(full), Cause::StorageFull);
  EXPECT_NE(full.error().message.find("max-store-bytes"), std::string::npos);
  EXPECT_EQ(store->bytes(), 8U);
  ASSERT_TRUE(store->create_part("a"));
  EXPECT_EQ(cause_of(store->write_part("a", 0, "abc")), Cause::StorageFull);
  EXPECT_TRUE(store->write_part("a", 0, "ab"));
  EXPECT_TRUE(store->write_part("a", 0, "xy")) << "the same place again";
  store->remove_part("a");
  EXPECT_TRUE(store->put("ab", sha256_of("ab")));
}

TEST(FileStore, SweepsWhatNobodyNeedsUnlessSomebodyHoldsIt) {
  const TemporaryFolder folder;
  const auto store = open(folder);
  const std::string kept = sha256_of("kept"), left = sha256_of("left");
  ASSERT_TRUE(store->put("kept", kept));
  ASSERT_TRUE(store->put("left", left));
  const auto in_use = [&]() -> Result<std::set<std::string>> { return std::set{kept}; };
  const auto mapped = store->map(left);
  {
    const auto held = store->hold();
    std::thread([&] { EXPECT_TRUE(store->sweep(in_use)); }).join();
    EXPECT_TRUE(store->has(left));
  }
  EXPECT_TRUE(store->sweep(in_use));
  EXPECT_FALSE(store->has(left));
  EXPECT_TRUE(store->has(kept));
  EXPECT_EQ(store->bytes(), 4U);
  EXPECT_EQ(mapped->bytes, "left") << "who reads it goes on";
  const auto unknown = []() -> Result<std::set<std::string>> { return Error{Cause::Internal, "no"}; };
  EXPECT_FALSE(store->sweep(unknown));
  EXPECT_TRUE(store->has(kept));
}

TEST(FileStore, GrowsPartsIntoFiles) {
  const TemporaryFolder folder;
  const auto store = open(folder);
  ASSERT_TRUE(store->create_part("a"));
  ASSERT_TRUE(store->write_part("a", 0, "me"));
  ASSERT_TRUE(store->write_part("a", 2, "sh and more"));
  EXPECT_EQ(*store->cut_part("a", 4), 4U);
  EXPECT_EQ(*store->cut_part("a", 100), 4U);
  ASSERT_TRUE(store->sync_part("a"));
  EXPECT_EQ(store->parts(), std::set<std::string>{"a"});
  EXPECT_EQ(*store->finish_part("a", ""), sha256_of("mesh"));
  EXPECT_EQ(store->map(sha256_of("mesh"))->bytes, "mesh");
  EXPECT_TRUE(store->parts().empty());
  EXPECT_EQ(store->bytes(), 4U);
  for (const Cause cause : {cause_of(store->write_part("a", 0, "x")), cause_of(store->sync_part("a")),
                            cause_of(store->cut_part("a", 0)), cause_of(store->finish_part("a", ""))})
    EXPECT_EQ(cause, Cause::NotFound);
}

TEST(FileStore, TakesTheSameBytesFromManyAtOnce) {
  const TemporaryFolder folder;
  const auto store = open(folder);
  const std::string bytes(100, 'x'), sha256 = sha256_of(bytes);
  std::vector<std::thread> threads;
  for (int i = 0; i < 8; ++i) threads.emplace_back([&] { EXPECT_TRUE(store->put(bytes, sha256)); });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(store->bytes(), 100U);
  EXPECT_EQ(files_below(folder / "store/files"), 1U);
}

}  // namespace
}  // namespace burnish
