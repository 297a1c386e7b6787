#include "server/http/page.h"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "server/http/gzip.h"
#include "server/http/header_value.h"

namespace burnish {
namespace {

constexpr std::string_view kFolder = "/assets/";
/// Draco's decoder is WebAssembly; blobs are images of textures and files that the page saves.
constexpr const char* kContentSecurityPolicy =
    "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; img-src 'self' blob: data:; object-src "
    "'none'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

bool never_changes(const PageFile& file) { return file.path.starts_with(kFolder); }

Result<std::string> unpacked(const PageFile& file) {
  std::string content;
  content.reserve(file.bytes);
  const ByteSink sink = [&content](std::string_view bytes) {
    content += bytes;
    return Result<>();
  };
  Inflater inflater;
  if (auto fed = inflater.feed(file.gzip, sink); !fed) return fed.error();
  if (auto whole = inflater.finish(); !whole) return whole.error();
  return content;
}

/// Every file has them: a worker obeys the policy of its own script.
HttpHeaders headers_of(const PageFile& file) {
  return {{"Content-Type", std::string(file.type)},
          {"ETag", "W/\"" + std::string(file.hash) + '"'},  // weak: compressed or not, it is the same
          {"Cache-Control", never_changes(file) ? "public, max-age=31536000, immutable" : "no-cache"},
          {"Content-Security-Policy", kContentSecurityPolicy},
          {"Cross-Origin-Opener-Policy", "same-origin"},
          {"Cross-Origin-Resource-Policy", "same-origin"},
          {"Referrer-Policy", "no-referrer"},
          {"X-Content-Type-Options", "nosniff"}};
}

Error nothing_at(std::span<const PageFile> files, const std::string& path) {
  if (!files.empty()) return {Cause::NotFound, "there is nothing at " + path};
  return {Cause::NotFound,
          "this server was built without its page; /openapi.json describes the calls. For the page run "
          "scripts/setup where there is an npm registry, and build again"};
}

}  // namespace

bool is_page_path(std::string_view path) { return path == "/" || path.starts_with(kFolder); }

Result<HttpResponse> page_answer(std::span<const PageFile> files, const HttpRequest& request) {
  const auto file = std::ranges::find(files, request.path, &PageFile::path);
  if (file == files.end()) return nothing_at(files, request.path);
  HttpResponse response{.headers = headers_of(*file)};
  const std::string_view known = request.header("If-None-Match");
  const std::string& etag = response.headers["ETag"];
  if (value_names(known, etag) || value_names(known, etag.substr(2)) || known == "*") {
    response.status = 304;
    return response;
  }
  response.headers["Vary"] = "Accept-Encoding";
  if (accepts_gzip(request.header("Accept-Encoding"))) {
    // Part of the program, so nobody's; what is sent as it lies has an owner.
    static const auto kProgram = std::make_shared<char>();
    response.file = {.bytes = file->gzip, .owner = kProgram};
    response.headers["Content-Encoding"] = "gzip";
    return response;
  }
  auto content = unpacked(*file);
  if (!content) return Error{Cause::Internal, "the page's file " + request.path + " is damaged"};
  const auto owner = std::make_shared<const std::string>(std::move(content).value());
  response.file = {.bytes = *owner, .owner = owner};
  return response;
}

}  // namespace burnish
