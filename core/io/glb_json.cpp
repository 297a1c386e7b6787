#include "core/io/glb_json.h"

#include <algorithm>
#include <array>
#include <unordered_set>

#include <nlohmann/json.hpp>

#include "core/io/pins.h"

namespace burnish {
namespace {

using Json = nlohmann::json;
using Kind = JsonValue::Kind;

constexpr std::size_t kDeepest = 64, kMostValues = 1'000'000, kValuesBetweenChecks = 4096;

constexpr std::array<std::string_view, 8> kRootMembers = {
    "asset",  "buffers", "bufferViews",    "accessors",
    "meshes", "nodes",   "extensionsUsed", "extensionsRequired"};
constexpr std::array<std::string_view, 8> kPassedOver = {"extras",   "min",     "max",    "matrix",
                                                         "rotation", "weights", "target", "children"};

/// Builds the tree event by event; an event that answers false ends the parser, whose own nesting is a heap
/// vector, not the stack.
class GltfReader {
 public:
  explicit GltfReader(const RunControl& run) : run_(run) {}

  Result<JsonValue> read(std::string_view text) {
    // The parser takes a NUL for the end, whatever follows.
    if (const std::size_t nul = text.find('\0'); nul != std::string_view::npos) {
      return Error{Cause::MalformedMesh,
                   "the JSON of the GLB holds a NUL byte at byte " + std::to_string(nul)};
    }
    if (!Json::sax_parse(text.begin(), text.end(), this)) return std::move(error_);
    if (!root_.is(Kind::Object)) return Error{Cause::MalformedMesh, "the JSON of the GLB is no object"};
    return std::move(root_);
  }

  // The events, by the names that nlohmann::json gives them.
  bool null() { return put({Kind::Null}); }
  bool boolean(bool value) { return put({Kind::Boolean, value ? 1.0 : 0.0}); }
  bool number_integer(Json::number_integer_t value) {
    return put({Kind::Number, static_cast<double>(value)});
  }
  bool number_unsigned(Json::number_unsigned_t value) {
    return put({Kind::Number, static_cast<double>(value)});
  }
  bool number_float(Json::number_float_t value, const std::string&) { return put({Kind::Number, value}); }
  bool string(std::string& value) { return put({Kind::String, 0, {}, std::move(value)}); }
  bool binary(Json::binary_t&) { return false; }  // never in text
  bool start_object(std::size_t) { return open(Kind::Object); }
  bool start_array(std::size_t) { return open(Kind::Array); }
  bool end_object() { return close(); }
  bool end_array() { return close(); }
  bool key(std::string& name) {
    if (skipping_ > 0) return true;
    Level& object = levels_.back();
    object.key = std::move(name);
    if (!object.seen.insert(object.key).second) {
      return fail(Cause::MalformedMesh, "names " + quote(object.key) + " twice in one object");
    }
    const bool kept =
        levels_.size() == 1 ? contains(kRootMembers, object.key) : !contains(kPassedOver, object.key);
    pass_over_ = !kept;
    return true;
  }
  bool parse_error(std::size_t at, const std::string&, const Json::exception& failure) {
    constexpr int kNumberOverflow = 406;
    return fail(Cause::MalformedMesh,
                (failure.id == kNumberOverflow ? "holds a number that is too large at byte "
                                               : "is malformed at byte ") +
                    std::to_string(at));
  }

 private:
  struct Level {
    JsonValue* value;
    std::string key = {};                       // in an object: of the member at hand
    std::unordered_set<std::string> seen = {};  // likewise
  };

  static bool contains(std::span<const std::string_view> names, std::string_view name) {
    return std::ranges::find(names, name) != names.end();
  }

  bool put(JsonValue value) {
    if (skipping_ > 0) return count();
    if (pass_over_) value = {};
    add(std::move(value));
    return count();
  }

  /// Ancestors get no further items while a value is open, so pointers to them stay good.
  JsonValue* add(JsonValue value) {
    pass_over_ = false;
    ++kept_;
    if (levels_.empty()) return &(root_ = std::move(value));
    value.name = std::move(levels_.back().key);
    std::vector<JsonValue>& items = levels_.back().value->items;
    items.push_back(std::move(value));
    return &items.back();
  }

  bool open(Kind kind) {
    if (levels_.size() + skipping_ == kDeepest) {
      return fail(Cause::TooLarge, "is nested deeper than " + std::to_string(kDeepest) + " levels");
    }
    if (pass_over_)
      add({});
    else if (skipping_ == 0) {
      levels_.push_back({add({kind})});
      return count();
    }
    ++skipping_;
    return count();
  }

  bool close() {
    if (skipping_ > 0) {
      --skipping_;
    } else {
      levels_.pop_back();
    }
    return true;
  }

  bool count() {
    if (kept_ > kMostValues) {
      return fail(Cause::TooLarge, "holds more than " + std::to_string(kMostValues) +
                                       " values in its meshes, nodes, accessors and views");
    }
    if (++values_ % kValuesBetweenChecks != 0 || !run_.stopped()) return true;
    error_ = run_.stop_error();
    return false;
  }

  bool fail(Cause cause, const std::string& what) {
    error_ = {cause, "the JSON of the GLB " + what};
    return false;
  }

  const RunControl& run_;
  JsonValue root_;
  std::vector<Level> levels_;
  std::size_t skipping_ = 0;  // levels open in a value that is passed over
  bool pass_over_ = false;    // the next value
  std::size_t kept_ = 0, values_ = 0;
  Error error_{Cause::MalformedMesh, "the JSON of the GLB is empty"};
};

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

/// Walks over text that is known to be JSON.
class Cursor {
 public:
  Cursor(std::string_view text, std::uint64_t at) : text_(text), at_(at) {}

  std::uint64_t at() const { return at_; }
  char next() {
    while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
    return at_ < text_.size() ? text_[at_] : '\0';
  }
  void step() { ++at_; }

  /// The value that begins here.
  TextRange value() {
    const char first = next();
    const std::uint64_t begin = at_;
    if (first == '"') {
      skip_string();
    } else if (first == '{' || first == '[') {
      skip_nested();
    } else {
      while (at_ < text_.size() && !is_blank(text_[at_]) && text_[at_] != ',' && text_[at_] != ']' &&
             text_[at_] != '}')
        ++at_;
    }
    return {begin, at_ - begin};
  }

 private:
  void skip_string() {
    for (++at_; at_ < text_.size() && text_[at_] != '"'; ++at_) at_ += text_[at_] == '\\';
    ++at_;
  }

  void skip_nested() {
    std::size_t depth = 0;
    do {
      const char c = next();
      if (c == '"') {
        skip_string();
        continue;
      }
      depth += static_cast<std::size_t>(c == '{' || c == '[');
      depth -= static_cast<std::size_t>(c == '}' || c == ']');
      ++at_;
    } while (depth > 0 && at_ < text_.size());
  }

  std::string_view text_;
  std::uint64_t at_;
};

/// `quoted` as it stands in the text, with its quotes.
bool names(std::string_view quoted, std::string_view name) {
  if (quoted.find('\\') != std::string_view::npos) return Json::parse(quoted).get<std::string>() == name;
  return quoted.substr(1, quoted.size() - 2) == name;
}

}  // namespace

const JsonValue* JsonValue::find(std::string_view member) const {
  if (!is(Kind::Object)) return nullptr;
  const auto found = std::ranges::find_if(items, [&](const JsonValue& item) { return item.name == member; });
  return found == items.end() ? nullptr : &*found;
}

Result<JsonValue> parse_gltf_json(std::string_view text, const RunControl& run) {
  return GltfReader(run).read(text);
}

TextRange json_root(std::string_view text) {
  const std::size_t brace = text.find('{');  // behind blanks, or a mark of UTF-8
  return {brace, text.size() - brace};
}

std::optional<TextRange> json_member(std::string_view text, TextRange object, std::string_view name) {
  Cursor cursor(text, object.begin);
  if (cursor.next() != '{') return {};
  cursor.step();
  while (cursor.next() == '"') {
    const TextRange key = cursor.value();
    cursor.next();
    cursor.step();  // over the colon
    const TextRange value = cursor.value();
    if (names(text.substr(key.begin, key.length), name)) return value;
    if (cursor.next() != ',') break;
    cursor.step();
  }
  return {};
}

std::vector<TextRange> json_elements(std::string_view text, TextRange array) {
  std::vector<TextRange> elements;
  Cursor cursor(text, array.begin);
  if (cursor.next() != '[') return elements;
  cursor.step();
  if (cursor.next() == ']') return elements;
  for (;;) {
    elements.push_back(cursor.value());
    if (cursor.next() != ',') return elements;
    cursor.step();
  }
}

}  // namespace burnish
