// One end of the socket between burnishd and a helper process: whole messages, with open files.
#pragma once

#include <google/protobuf/message_lite.h>

#include <chrono>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "server/store/file.h"

namespace burnish {

/// One thread may receive while any send.
class Channel {
 public:
  /// The two ends. Both files are -1 when there are no more.
  static std::pair<File, File> pair();

  explicit Channel(File socket) : socket_(std::move(socket)) {}

  /// False when the other end is gone.
  bool send(const google::protobuf::MessageLite& message, std::span<const int> files = {});

  /// `Unread`: gone, and what was sent last was never read.
  enum class Got { Message, Nothing, Gone, Unread };
  /// Waits for one message so long, or for ever; an end that stops in the middle of a message is gone.
  Got receive(google::protobuf::MessageLite& message, std::optional<std::chrono::milliseconds> timeout = {},
              std::vector<File>* files = nullptr);

 private:
  bool read_all(char* to, std::size_t size);

  File socket_;
  std::mutex sending_;
};

}  // namespace burnish
