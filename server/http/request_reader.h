// The bytes of a connection's requests, with the limits on how large a head may be and how slowly heads and
// bodies may come.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "server/http/connection.h"

namespace burnish {

class RequestReader {
 public:
  using Clock = Connection::Clock;
  enum class Head : std::uint8_t {
    Whole,
    Cut,       ///< the client stopped in the middle; what came can be read
    None,      ///< no further request
    TooLarge,  ///< more than kMaxHeadBytes
    LongLine,  ///< the first one has more than kMaxLineBytes
    TooSlow,
    Stopping,  ///< the server ends while it comes
  };
  static constexpr std::size_t kMaxHeadBytes = 64 << 10;
  static constexpr std::size_t kMaxLineBytes = 8 << 10;  ///< the library's time grows with its square

  RequestReader(Connection& connection, const HttpPatience& patience);

  /// Waits for the whole head of the next request; `first` on this connection.
  Head read_head(bool first);

  /// Bytes of the head; after begin_body() of the body; -1 when none come in time, 0 at the end of the head.
  ssize_t read(char* into, std::size_t size);

  /// The value of the head's Range, which the library never sees; empty: none.
  const std::string& range() const { return range_; }

  void begin_body();  ///< its time starts now
  void end_body();    ///< read() gives no more of it, whatever comes; skip() does
  bool in_body() const { return body_ == Body::Open; }
  bool skip(std::uint64_t bytes);

  std::uint64_t body_bytes() const { return body_bytes_; }  ///< that were read, as they came
  /// Why read() ended: Bytes when it did not.
  Connection::Event ended() const { return ended_; }

 private:
  Connection::Event fill(Clock::time_point until);
  std::string_view buffered() const { return {buffer_.data() + begin_, end_ - begin_}; }
  Head take_head(std::size_t size, Head as);
  ssize_t read_body(char* into, std::size_t size);

  Connection& connection_;
  const HttpPatience& patience_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0, end_ = 0;  ///< of what is in the buffer
  std::string head_, range_;
  std::size_t head_read_ = 0;
  enum class Body : std::uint8_t { NotYet, Open, Closed } body_ = Body::NotYet;
  std::uint64_t body_bytes_ = 0;
  Clock::time_point body_begun_;
  Connection::Event ended_ = Connection::Event::Bytes;
};

}  // namespace burnish
