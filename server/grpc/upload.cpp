#include "server/grpc/upload.h"

#include <string>

namespace burnish {
namespace {

Error bad_request(const std::string& sentence) { return {Cause::BadRequest, sentence}; }

std::string bytes(std::uint64_t count) { return std::to_string(count) + " bytes"; }

}  // namespace

Result<> Upload::start(const UploadSizes& declared) {
  if (started_) return bad_request("a second start; the first message is the start, all others are chunks");
  started_ = true;
  if (auto fits = declare(mesh_, declared.mesh); !fits) return fits;
  return declare(reference_, declared.reference);
}

Result<> Upload::declare(Part& part, std::uint64_t size) const {
  if (size > max_bytes_) {
    return Error{Cause::TooLarge, std::string("the ") + part.name + " is to have " + bytes(size) +
                                      "; the limit is " + std::to_string(max_bytes_) + " (max-bytes)"};
  }
  part.declared = size;
  return {};
}

Result<> Upload::append(UploadPart which, std::string_view chunk) {
  Part& part = which == UploadPart::Mesh ? mesh_ : reference_;
  if (!started_) return bad_request(std::string("a chunk of the ") + part.name + " came before the start");
  if (chunk.empty()) return bad_request(std::string("a chunk of the ") + part.name + " is empty");
  if (!part.body) part.body = spool_.body(part.declared);
  const std::uint64_t size = part.body->size() + chunk.size();
  if (part.declared != 0 && size > part.declared) {
    return bad_request(std::string("more bytes of the ") + part.name + " than the " +
                       std::to_string(part.declared) + " that the start declared");
  }
  if (size > max_bytes_) {
    return Error{Cause::TooLarge,
                 std::string("the ") + part.name + " has more than " + bytes(max_bytes_) + " (max-bytes)"};
  }
  return part.body->append(chunk);
}

Error Upload::empty_message() { return bad_request("a message is neither a start nor a chunk"); }

Result<> Upload::finish(bool needs_reference) {
  if (!started_) return bad_request("the stream ended before its start");
  if (auto whole = finish(mesh_, true); !whole) return whole;
  return finish(reference_, needs_reference);
}

Result<> Upload::finish(Part& part, bool needed) {
  const std::uint64_t size = part.body ? part.body->size() : 0;
  if (part.declared != 0 && size != part.declared) {
    return bad_request("the stream ended after " + std::to_string(size) + " of the " + bytes(part.declared) +
                       " of the " + part.name + " that the start declared");
  }
  if (!part.body) {
    if (needed) return bad_request(std::string("the stream ended without a ") + part.name);
    return {};
  }
  auto view = part.body->finish();
  if (!view) return view.error();
  part.view = *view;
  return {};
}

}  // namespace burnish
