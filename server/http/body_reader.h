// What a request carries, on its way from the wire into the spool, within the limits.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/gzip.h"
#include "server/http/http_message.h"
#include "server/jobs/spool.h"
#include "server/service/limits.h"

namespace burnish {

/// Undoes a body's Content-Encoding and hands the bytes on in large pieces, however small they came.
class BodyDecoder {
 public:
  /// Errors: UnsupportedFormat.
  static Result<std::unique_ptr<BodyDecoder>> for_encoding(std::string_view content_encoding);

  /// Errors: BadRequest, and the sink's own.
  Result<> feed(std::string_view bytes, const ByteSink& sink);
  Result<> finish(const ByteSink& sink);

 private:
  Result<> collect(std::string_view bytes, const ByteSink& sink);

  std::optional<Inflater> inflater_;
  std::string collected_;
};

/// The parts of a body, each in the spool.
class BodyParts {
 public:
  BodyParts(Spool& spool, const RequestLimits& limits) : spool_(spool), limits_(limits) {}

  /// The whole body is one part, of so many bytes if that is known. Then append(), then finish().
  void begin_whole(std::uint64_t expected);
  /// Another part of a form. Errors: BadRequest for too many, and what the part before it ended with.
  Result<> begin(std::string name, std::string content_type);
  /// Errors: TooLarge, MemoryFull, StorageFull.
  Result<> append(std::string_view bytes);
  /// Puts them into the request. Errors: OutOfMemory.
  Result<> finish(HttpRequest& request);

 private:
  void open(std::string what, std::uint64_t limit, std::string_view limit_name, std::uint64_t expected = 0);
  Result<> close();

  Spool& spool_;
  const RequestLimits& limits_;
  bool form_ = true;
  std::vector<FormPart> parts_;
  std::shared_ptr<Body> body_;  ///< of the last part
  std::string what_;            ///< "the part 'mesh'"
  std::uint64_t limit_ = 0;
  std::string_view limit_name_;
};

}  // namespace burnish
