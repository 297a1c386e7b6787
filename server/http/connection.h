// One client's connection: bytes in, bytes out, and whether the client is still there. Knows nothing of HTTP.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace burnish {

/// How long clients may take. A client that is slower loses its connection, not the others theirs.
struct HttpPatience {
  std::chrono::milliseconds head{10'000};   ///< for the whole head of a request
  std::chrono::milliseconds idle{5'000};    ///< for the first byte of a connection's next request
  std::chrono::milliseconds body{10'000};   ///< before a body's average rate counts
  std::chrono::milliseconds stall{30'000};  ///< without any byte, in a body or in an answer
  std::uint32_t min_body_rate = 1024;       ///< bytes a second, both ways; 0: any

  /// Until when a body or an answer that began at `begun` and has moved `bytes` must move the next one.
  std::chrono::steady_clock::time_point deadline(std::chrono::steady_clock::time_point begun,
                                                 std::chrono::milliseconds grace, std::uint64_t bytes) const;
};

/// Set once; wakes every connection that waits for its client. Thread-safe.
class StopEvent {
 public:
  StopEvent();
  ~StopEvent();
  StopEvent(const StopEvent&) = delete;
  StopEvent& operator=(const StopEvent&) = delete;

  void set();
  bool is_set() const { return set_; }
  int file() const { return file_; }  ///< becomes readable; -1: the process has no file to spare

 private:
  const int file_;
  std::atomic<bool> set_ = false;
};

/// Used by one thread.
class Connection {
 public:
  using Clock = std::chrono::steady_clock;
  enum class Event : std::uint8_t {
    Bytes,
    End,       ///< the client sends no more, or is gone
    TimedOut,  ///< no byte came in time
    Stopping,  ///< the server ends
  };
  struct Received {
    Event event = Event::End;
    std::size_t size = 0;
  };

  virtual ~Connection() = default;

  /// Waits for the first bytes that come.
  virtual Received receive(std::span<char> into, Clock::time_point until) = 0;

  /// The same for bytes that nobody wants, at most `most` of them.
  virtual Received drop(std::size_t most, Clock::time_point until);

  /// Sends both; false when the client does not take them.
  virtual bool send(std::string_view first, std::string_view second) = 0;

  /// Whether nobody reads any more. A client that closed its sending side may still read, and TCP tells only
  /// one who sends; `question` is sent then, now and again, and must mean nothing to a client that is there.
  /// Empty: it counts as gone at once.
  virtual bool gone(std::string_view question) = 0;

  /// Lets the client read the answer although it still sends: closing at once would reset the connection.
  virtual void linger() = 0;

  virtual bool stopping() const = 0;  ///< the server ends
};

/// On a connected socket, which it owns and closes.
class SocketConnection final : public Connection {
 public:
  SocketConnection(int socket, const StopEvent& stop, const HttpPatience& patience);
  ~SocketConnection() override;

  Received receive(std::span<char> into, Clock::time_point until) override;
  Received drop(std::size_t most, Clock::time_point until) override;
  bool send(std::string_view first, std::string_view second) override;
  bool gone(std::string_view question) override;
  void linger() override;
  bool stopping() const override { return stop_.is_set(); }

  void abort();  ///< ends it at once, from any thread

 private:
  Received receive(char* into, std::size_t size, int how, Clock::time_point until);

  const int socket_;
  const StopEvent& stop_;
  const HttpPatience& patience_;
  bool tells_gone_ = false;  ///< it is a Unix socket
  Clock::time_point ask_again_ = Clock::time_point::min();
};

/// A client that sent everything at once and closed its sending side; for tests and fuzzing.
class MemoryConnection final : public Connection {
 public:
  explicit MemoryConnection(std::string_view bytes) : input_(bytes) {}

  Received receive(std::span<char> into, Clock::time_point until) override;
  bool send(std::string_view first, std::string_view second) override;
  bool gone(std::string_view) override { return false; }
  void linger() override {}
  bool stopping() const override { return false; }

  std::string take_output() { return std::move(output_); }

 private:
  std::string_view input_;
  std::string output_;
};

}  // namespace burnish
