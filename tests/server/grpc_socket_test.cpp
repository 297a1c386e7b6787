// gRPC on a Unix domain socket.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "server/unix_socket.h"
#include "tests/server/running_grpc.h"

namespace burnish {
namespace {

using testing::RunningGrpc;

std::string free_path() { return std::filesystem::temp_directory_path() / ("burnish_" + new_request_id()); }

Config on_socket(const std::string& path) {
  Config config;
  config.grpc_listen = Address{.host = "", .port = 0, .path = path};
  return config;
}

grpc::Status list_methods_of(RunningGrpc& server) {
  grpc::ClientContext context;
  v1::ListMethodsResponse response;
  return server.stub().ListMethods(&context, {}, &response);
}

/// What a server leaves that was killed: a socket without a listener.
void leave_stale_socket(const std::string& path) {
  const int file = ::socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  ASSERT_EQ(::bind(file, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  ::close(file);
}

TEST(GrpcSocket, ServesAndLeavesNoFile) {
  const std::string path = free_path();
  {
    RunningGrpc server({.config = on_socket(path)});
    EXPECT_TRUE(std::filesystem::is_socket(path));
    EXPECT_EQ(server.server().address().text(), "unix:" + path);
    const grpc::Status status = list_methods_of(server);
    EXPECT_TRUE(status.ok()) << status.error_message();
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(GrpcSocket, ReplacesOneThatADeadServerLeft) {
  const std::string path = free_path();
  leave_stale_socket(path);
  RunningGrpc server({.config = on_socket(path)});
  EXPECT_TRUE(list_methods_of(server).ok());
}

TEST(GrpcSocket, IsNotTakenFromAServerThatLives) {
  const std::string path = free_path();
  RunningGrpc first({.config = on_socket(path)});
  const auto second =
      GrpcServer::start(on_socket(path), first.jobs(), first.house().durable_jobs, first.house().uploads);
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().message, "cannot listen on unix:" + path + ": a server listens there already");
  EXPECT_TRUE(list_methods_of(first).ok()) << "the first one is unharmed";
}

TEST(GrpcSocket, NeverReplacesAnotherFile) {
  const std::string path = free_path();
  std::ofstream(path) << "precious";
  EXPECT_FALSE(clear_unix_socket(path).ok());
  EXPECT_EQ(std::filesystem::file_size(path), 8u);
  std::filesystem::remove(path);
}

TEST(GrpcSocket, RefusesAPathThatIsTooLong) {
  const auto cleared = clear_unix_socket("/" + std::string(200, 'x'));
  ASSERT_FALSE(cleared.ok());
  EXPECT_EQ(cleared.error().cause, Cause::BadOption);
}

}  // namespace
}  // namespace burnish
