#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "server/http/smooth_query.h"

namespace {

/// "a=1&b=2" as names and values, which the HTTP library has decoded by then.
burnish::Query split(std::string_view text) {
  burnish::Query query;
  while (!text.empty()) {
    const std::string_view pair = text.substr(0, text.find('&'));
    const std::size_t equals = pair.find('=');
    query.emplace(pair.substr(0, equals),
                  equals == std::string_view::npos ? std::string_view() : pair.substr(equals + 1));
    text.remove_prefix(pair.size() == text.size() ? text.size() : pair.size() + 1);
  }
  return query;
}

void expect_sentence(const burnish::Error& error) {
  if (!error.message.empty() && error.cause != burnish::Cause::Internal) return;
  std::fprintf(stderr, "refused as internal or without a word: \"%s\"\n", error.message.c_str());
  std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const char* data, std::size_t size) {
  const burnish::Query query = split({data, size});
  if (const auto options = burnish::parse_query_options(query); !options) expect_sentence(options.error());
  if (const auto timeout = burnish::parse_timeout(query); !timeout) expect_sentence(timeout.error());
  return 0;
}
