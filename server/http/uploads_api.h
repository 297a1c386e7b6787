// /v1/uploads: meshes that come in pieces, after the IETF's draft of resumable uploads
// (draft-ietf-httpbis-resumable-upload).
#pragma once

#include <memory>
#include <string>

#include "server/http/http_message.h"
#include "server/jobs/uploads.h"

namespace burnish {

/// Each is one verb of one path. Errors: those of Uploads; BadRequest and UnsupportedFormat for headers,
/// naming them. Thread-safe.
class UploadsApi {
 public:
  explicit UploadsApi(Uploads& uploads) : uploads_(uploads) {}

  /// POST, with the first bytes or none: Upload-Length, Upload-Complete and Repr-Digest may tell of the rest.
  /// Answers 201 with Location. `request` must outlive the taker.
  Result<std::unique_ptr<BodyTaker>> create(const HttpRequest& request, const Caller& caller);
  /// PATCH: the bytes from Upload-Offset on; Upload-Complete: ?1 with the last.
  Result<std::unique_ptr<BodyTaker>> append(const HttpRequest& request, const Caller& caller,
                                            const std::string& id);
  Result<HttpResponse> get(const Caller& caller, const std::string& id);
  Result<HttpResponse> remove(const Caller& caller, const std::string& id);
  /// Upload-Offset of an upload, for the answer to an append that did not begin there; "": there is none.
  std::string offset_of(const Caller& caller, const std::string& id);

 private:
  Uploads& uploads_;
};

}  // namespace burnish
