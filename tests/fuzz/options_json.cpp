#include "server/http/options_json.h"

#include <cstdio>
#include <cstdlib>

namespace {

[[noreturn]] void fail(const char* what, const std::string& message) {
  std::fprintf(stderr, "%s: %s\n", what, message.c_str());
  std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const char* data, std::size_t size) {
  using namespace burnish;
  static const SmoothService service;
  const auto options = parse_options_json({data, size}, service);
  if (!options) {
    if (!options.error().field.starts_with("options")) fail("names no place", options.error().message);
  } else if (const auto checked = service.check(*options); !checked) {
    fail("accepted, but not by the service", checked.error().message);
  }
  return 0;
}
