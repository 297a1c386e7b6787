#include "server/http/gzip.h"

#include <algorithm>
#include <array>
#include <memory>
#include <new>

#include "server/http/header_value.h"

namespace burnish {
namespace {

constexpr std::size_t kCompressAtOnce = 256 << 10, kOutput = 64 << 10;
constexpr int kLargestWindow = 15, kAsGzip = 16, kGzipOrDeflate = 32;  // as zlib.h adds them up
constexpr int kDefaultMemory = 8;

Bytef* bytes_of(std::string_view text) {
  return reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));  // zlib only reads them
}

}  // namespace

bool accepts_gzip(std::string_view accept_encoding) {
  std::optional<double> named, any;
  double plain = 0;  // accepted last, unless it is named
  for (const std::string_view item : split_value(accept_encoding, ',')) {
    const std::string_view coding = split_value(item, ';').front();
    if (same_ignoring_case(coding, "gzip") || same_ignoring_case(coding, "x-gzip")) named = quality_of(item);
    if (coding == "*") any = quality_of(item);
    if (same_ignoring_case(coding, "identity")) plain = quality_of(item);
  }
  const double quality = named.value_or(any.value_or(0));
  return quality > 0 && quality >= plain;
}

std::optional<std::string> gzip(std::string_view bytes, const std::function<bool()>& give_up) {
  z_stream stream{};
  if (deflateInit2(&stream, Z_BEST_SPEED, Z_DEFLATED, kLargestWindow + kAsGzip, kDefaultMemory,
                   Z_DEFAULT_STRATEGY) != Z_OK) {
    throw std::bad_alloc();
  }
  const std::unique_ptr<z_stream, int (*)(z_stream*)> ended_at_last(&stream, deflateEnd);
  std::string compressed;
  std::array<char, kOutput> piece;
  while (true) {
    int state = Z_OK;
    const std::string_view next = bytes.substr(0, kCompressAtOnce);
    bytes.remove_prefix(next.size());
    stream.next_in = bytes_of(next);
    stream.avail_in = static_cast<uInt>(next.size());
    do {
      stream.next_out = reinterpret_cast<Bytef*>(piece.data());
      stream.avail_out = static_cast<uInt>(piece.size());
      state = deflate(&stream, bytes.empty() ? Z_FINISH : Z_NO_FLUSH);
      compressed.append(piece.data(), piece.size() - stream.avail_out);
    } while (stream.avail_out == 0);
    if (state == Z_STREAM_END) return compressed;
    if (give_up()) return {};
  }
}

Inflater::Inflater() {
  if (inflateInit2(&stream_, kLargestWindow + kGzipOrDeflate) != Z_OK) throw std::bad_alloc();
}

Inflater::~Inflater() { inflateEnd(&stream_); }

Result<> Inflater::feed(std::string_view bytes, const ByteSink& sink) {
  std::array<char, kOutput> piece;
  stream_.next_in = bytes_of(bytes);
  stream_.avail_in = static_cast<uInt>(bytes.size());
  while (stream_.avail_in > 0) {
    begun_ = true;
    stream_.next_out = reinterpret_cast<Bytef*>(piece.data());
    stream_.avail_out = static_cast<uInt>(piece.size());
    const int state = inflate(&stream_, Z_NO_FLUSH);
    if (state == Z_MEM_ERROR) return Error{Cause::OutOfMemory, "no memory to decompress the body"};
    if (state != Z_OK && state != Z_STREAM_END) {
      return Error{Cause::BadRequest, "the body is not compressed as its Content-Encoding says"};
    }
    if (auto taken = sink({piece.data(), piece.size() - stream_.avail_out}); !taken) return taken;
    if (state == Z_STREAM_END) {  // gzip files may be joined
      begun_ = false;
      inflateReset(&stream_);
    }
  }
  return {};
}

Result<> Inflater::finish() const {
  if (begun_) return Error{Cause::BadRequest, "the compressed body is cut off"};
  return {};
}

}  // namespace burnish
