// The page for people: files that were compressed when they were built, served from this program.
#pragma once

#include <span>
#include <string_view>

#include "server/http/http_message.h"

namespace burnish {

/// A file of the page. One whose path holds a hash of its content never changes.
struct PageFile {
  std::string_view path;  ///< "/" or "/assets/view-Dk3x.js"
  std::string_view type;  ///< as in Content-Type
  std::string_view hash;  ///< of the content, hexadecimal
  std::string_view gzip;  ///< the content, compressed
  std::size_t bytes = 0;  ///< of the content
};

/// What client/web/embed.mjs wrote; empty in a program that was built without npm.
std::span<const PageFile> page_files();

inline constexpr std::string_view kPageVerbs = "GET, HEAD, OPTIONS";

/// Whether a path belongs to the page, be there such a file or not.
bool is_page_path(std::string_view path);

/// The file, compressed for those who accept that, with the headers that keep the page from asking anybody
/// but this server; 304 to a caller who has it. Errors: NotFound.
Result<HttpResponse> page_answer(std::span<const PageFile> files, const HttpRequest& request);

}  // namespace burnish
