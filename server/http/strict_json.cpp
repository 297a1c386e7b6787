#include "server/http/strict_json.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

namespace burnish {
namespace {

using Json = nlohmann::json;

/// Builds the value event by event; an event that answers false ends the parser, whose own nesting is a heap
/// vector, not the stack.
class StrictReader {
 public:
  explicit StrictReader(std::string root_name) : root_name_(std::move(root_name)) {}

  Result<Json> read(std::string_view text) {
    // The parser takes a NUL for the end, whatever follows.
    if (text.find('\0') != std::string_view::npos) {
      return Error{Cause::BadOption, root_name_ + " is not valid: it holds a NUL byte", root_name_};
    }
    if (!Json::sax_parse(text.begin(), text.end(), this)) return std::move(error_);
    return std::move(root_);
  }

  // The events, by the names that nlohmann::json gives them.
  bool null() { return fail(place(), "is null; leave it out instead"); }
  bool boolean(bool value) { return put(value); }
  bool number_integer(Json::number_integer_t value) { return put(value); }
  bool number_unsigned(Json::number_unsigned_t value) { return put(value); }
  bool number_float(Json::number_float_t value, const std::string&) { return put(value); }
  bool string(std::string& value) { return put(std::move(value)); }
  bool binary(Json::binary_t&) { return false; }  // never in text
  bool start_object(std::size_t) { return open(Json::object()); }
  bool start_array(std::size_t) { return open(Json::array()); }
  bool end_object() { return close(); }
  bool end_array() { return close(); }
  bool key(std::string& name) {
    Level& object = levels_.back();
    object.key = std::move(name);
    return !object.value->contains(object.key) || fail(place(), "is given twice");
  }
  bool parse_error(std::size_t, const std::string&, const Json::exception& failure) {
    constexpr int kNumberOverflow = 406;
    const std::string text = failure.what();
    const std::string reason = text.substr(std::min(text.size(), text.find("] ") + 2));
    return fail(failure.id == kNumberOverflow ? place() : root_name_, "is not valid: " + reason);
  }

 private:
  struct Level {
    Json* value;
    std::string key = {};  ///< in an object: of the member at hand
  };

  bool put(Json value) {
    add(std::move(value));
    return true;
  }

  Json* add(Json value) {
    if (levels_.empty()) return &(root_ = std::move(value));
    Level& level = levels_.back();
    if (level.value->is_object()) return &((*level.value)[level.key] = std::move(value));
    level.value->push_back(std::move(value));
    return &level.value->back();
  }

  bool open(Json container) {
    if (levels_.size() == kDeepestJson) {
      return fail(place(), "is nested deeper than " + std::to_string(kDeepestJson) + " levels");
    }
    levels_.push_back({add(std::move(container))});
    return true;
  }

  bool close() {
    levels_.pop_back();
    return true;
  }

  /// Of the value that comes next.
  std::string place() const {
    std::string path = root_name_;
    for (const Level& level : levels_) {
      const bool innermost = &level == &levels_.back();
      path += level.value->is_object()
                  ? "." + level.key
                  : "[" + std::to_string(level.value->size() - (innermost ? 0 : 1)) + "]";
    }
    return path;
  }

  bool fail(const std::string& where, const std::string& what) {
    error_ = {Cause::BadOption, where + " " + what, where};
    return false;
  }

  const std::string root_name_;
  Json root_;
  std::vector<Level> levels_;  ///< containers that are open
  Error error_;
};

}  // namespace

Result<Json> parse_strict_json(std::string_view text, const std::string& root) {
  return StrictReader(root).read(text);
}

}  // namespace burnish
