#include "client/cli/files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/client/temporary_folder.h"

namespace burnish::cli {
namespace {

namespace fs = std::filesystem;

TEST(ReadFile, ReturnsEveryByte) {
  const TemporaryFolder folder;
  std::string bytes(3 << 20, '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * 7);
  const Result<std::string> read = read_file(folder.write("big", bytes));
  ASSERT_TRUE(read.ok());
  EXPECT_TRUE(*read == bytes);
  EXPECT_EQ(*read_file(folder.write("empty", "")), "");
}

TEST(ReadFile, NamesWhatItCannotRead) {
  const TemporaryFolder folder;
  const std::pair<std::string, const char*> rows[] = {{folder / "missing", "No such file"},
                                                      {folder / "", "Is a directory"}};
  for (const auto& [path, reason] : rows) {
    const Result<std::string> read = read_file(path);
    ASSERT_FALSE(read.ok()) << path;
    EXPECT_EQ(read.error().cause, Cause::FileError);
    EXPECT_THAT(read.error().message, testing::AllOf(testing::HasSubstr(path), testing::HasSubstr(reason)));
  }
}

TEST(WriteFile, ReplacesTheWholeFileAndKeepsItsPermissions) {
  const TemporaryFolder folder;
  const std::string path = folder.write("mesh.obj", "a longer old text");
  fs::permissions(path, fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_read);
  ASSERT_TRUE(write_file(path, "new").ok());
  EXPECT_EQ(folder.read("mesh.obj"), "new");
  EXPECT_EQ(fs::status(path).permissions(), static_cast<fs::perms>(0640));
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(WriteFile, FollowsASymbolicLink) {
  const TemporaryFolder folder;
  folder.write("real.obj", "old");
  fs::create_symlink("real.obj", folder / "link.obj");
  ASSERT_TRUE(write_file(folder / "link.obj", "new").ok());
  EXPECT_TRUE(fs::is_symlink(folder / "link.obj"));
  EXPECT_EQ(folder.read("real.obj"), "new");
}

TEST(WriteFile, WritesToDevicesInPlace) {
  EXPECT_TRUE(write_file("/dev/null", "anything").ok());
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  const Result<> full = write_file("/dev/full", "anything");
  ASSERT_FALSE(full.ok());
  EXPECT_THAT(full.error().message, testing::HasSubstr("No space left"));
}

TEST(CheckWritable, AgreesWithWriteFileAndLeavesNothing) {
  const TemporaryFolder folder;
  EXPECT_TRUE(check_writable(folder / "new.obj").ok());
  EXPECT_EQ(folder.entries(), 0u);
  for (const std::string& path : {folder / "", folder / "missing/new.obj"}) {
    ASSERT_FALSE(check_writable(path).ok()) << path;
    EXPECT_EQ(check_writable(path).error(), write_file(path, "bytes").error());
  }
}

}  // namespace
}  // namespace burnish::cli
