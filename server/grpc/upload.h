// The bytes of a mesh and of a reference as a stream brings them, and the rules of the stream.
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>

#include "server/jobs/spool.h"

namespace burnish {

enum class UploadPart : std::uint8_t { Mesh, Reference };

struct UploadSizes {
  std::uint64_t mesh = 0;  ///< bytes; 0 = not known
  std::uint64_t reference = 0;
};

/// One start, then chunks of both parts in any order, then the end. Breaking a rule is BadRequest; after an
/// error nothing more may be called. Not thread-safe.
class Upload {
 public:
  /// `max_bytes` of each part.
  Upload(Spool& spool, std::uint64_t max_bytes) : spool_(spool), max_bytes_(max_bytes) {}

  /// Errors: BadRequest, TooLarge.
  Result<> start(const UploadSizes& declared);
  /// Errors: BadRequest, TooLarge, those of Body::append().
  Result<> append(UploadPart part, std::string_view bytes);
  /// The message that was neither a start nor a chunk.
  static Error empty_message();
  /// No more append(). Errors: BadRequest when a part is missing or not complete, those of Body::finish().
  Result<> finish(bool needs_reference);

  bool started() const { return started_; }
  /// After finish(), as long as the Upload lives; empty when there is none.
  std::string_view mesh() const { return mesh_.view; }
  std::string_view reference() const { return reference_.view; }

 private:
  struct Part {
    const char* name;
    std::uint64_t declared = 0;
    std::unique_ptr<Body> body = {};
    std::string_view view = {};
  };
  Result<> declare(Part& part, std::uint64_t bytes) const;
  static Result<> finish(Part& part, bool needed);

  Spool& spool_;
  const std::uint64_t max_bytes_;
  bool started_ = false;
  Part mesh_{"mesh"}, reference_{"reference"};
};

}  // namespace burnish
