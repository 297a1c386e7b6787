#include "server/http/request_reader.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "server/http/http_message.h"

namespace burnish {
namespace {

using Event = Connection::Event;

constexpr std::size_t kPiece = 16 << 10;  ///< asked of the connection at once
constexpr std::string_view kLineEnd = "\r\n", kHeadEnd = "\r\n\r\n";

bool is_range(std::string_view line) {
  const IgnoreCase less;
  const std::string_view name = line.substr(0, line.find(':'));
  return !less(name, "Range") && !less("Range", name);
}

/// The library answers 416 to every Range that it cannot parse or meet, even to a POST: it never gets one.
std::string without_range(std::string_view head, std::string& range) {
  std::string kept;
  range.clear();
  kept.reserve(head.size());
  while (!head.empty()) {
    const std::size_t end = head.find(kLineEnd);
    const std::string_view line = head.substr(0, end == std::string_view::npos ? end : end + kLineEnd.size());
    if (is_range(line)) {
      range = line.substr(line.find(':') + 1);
    } else {
      kept.append(line);
    }
    head.remove_prefix(line.size());
  }
  return kept;
}

}  // namespace

RequestReader::RequestReader(Connection& connection, const HttpPatience& patience)
    : connection_(connection), patience_(patience), buffer_(kPiece) {}

RequestReader::Head RequestReader::read_head(bool first) {
  head_.clear();
  body_ = Body::NotYet;
  ended_ = Event::Bytes;
  body_bytes_ = head_read_ = 0;
  bool begun = first, blank_line_allowed = true;
  auto until = Clock::now() + (first ? patience_.head : patience_.idle);
  std::size_t searched = 0;
  while (true) {
    if (blank_line_allowed && buffered().starts_with(kLineEnd)) {  // as RFC 9112 asks
      begin_ += kLineEnd.size();
      blank_line_allowed = false;
    }
    const std::size_t end = buffered().find(kHeadEnd, searched);
    if (end < kMaxHeadBytes) return take_head(end + kHeadEnd.size(), Head::Whole);
    const std::size_t size = buffered().size();
    if (size >= kMaxHeadBytes) return Head::TooLarge;
    searched = size - std::min(size, kHeadEnd.size() - 1);
    if (!begun && size > 0) {
      begun = true;
      until = Clock::now() + patience_.head;
    }
    const Event event = fill(until);
    if (event == Event::Bytes) continue;
    if (buffered().empty()) return Head::None;
    if (event == Event::TimedOut) return Head::TooSlow;
    if (event == Event::Stopping) return Head::Stopping;
    return take_head(buffered().size(), Head::Cut);
  }
}

RequestReader::Head RequestReader::take_head(std::size_t size, Head as) {
  const std::string_view head = buffered().substr(0, size);
  begin_ += size;
  if (std::min(head.find(kLineEnd), head.size()) > kMaxLineBytes) return Head::LongLine;
  head_ = without_range(head, range_);
  return as;
}

Event RequestReader::fill(Clock::time_point until) {
  if (begin_ == end_) begin_ = end_ = 0;
  if (buffer_.size() - end_ < kPiece / 2) {  // only while a head is larger than usual
    std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(begin_),
              buffer_.begin() + static_cast<std::ptrdiff_t>(end_), buffer_.begin());
    end_ -= begin_;
    begin_ = 0;
    buffer_.resize(std::max(buffer_.size(), end_ + kPiece));
  }
  const auto received = connection_.receive(std::span(buffer_).subspan(end_), until);
  end_ += received.size;
  return received.event;
}

ssize_t RequestReader::read(char* into, std::size_t size) {
  if (head_read_ < head_.size()) {
    const std::size_t some = head_.copy(into, size, head_read_);
    head_read_ += some;
    return static_cast<ssize_t>(some);
  }
  switch (body_) {
    case Body::NotYet:
      return 0;
    case Body::Closed:
      return -1;
    case Body::Open:
      return read_body(into, size);
  }
  return -1;
}

ssize_t RequestReader::read_body(char* into, std::size_t size) {
  if (begin_ == end_ && ended_ == Event::Bytes)
    ended_ = fill(patience_.deadline(body_begun_, patience_.body, body_bytes_));
  if (ended_ != Event::Bytes) return -1;
  const std::size_t some = buffered().copy(into, size);
  begin_ += some;
  body_bytes_ += some;
  return static_cast<ssize_t>(some);
}

void RequestReader::begin_body() {
  body_ = Body::Open;
  body_begun_ = Clock::now();
}

void RequestReader::end_body() { body_ = Body::Closed; }

bool RequestReader::skip(std::uint64_t bytes) {
  const std::uint64_t here = std::min<std::uint64_t>(bytes, buffered().size());
  begin_ += here;
  body_bytes_ += here;
  if (ended_ != Event::Bytes) return bytes == here;
  for (bytes -= here; bytes > 0;) {
    const auto dropped =
        connection_.drop(bytes, patience_.deadline(body_begun_, patience_.body, body_bytes_));
    if (dropped.event != Event::Bytes) return false;
    bytes -= dropped.size;
    body_bytes_ += dropped.size;
  }
  return true;
}

}  // namespace burnish
