#include "core/io/ply_header.h"

#include <algorithm>
#include <array>
#include <charconv>

#include "core/io/pins.h"
#include "core/io/text_scan.h"

namespace burnish {
namespace {

struct TypeName {
  std::string_view name, other_name;
  std::uint64_t size;
};
constexpr std::array<TypeName, 8> kTypes{{{"char", "int8", 1},
                                          {"uchar", "uint8", 1},
                                          {"short", "int16", 2},
                                          {"ushort", "uint16", 2},
                                          {"int", "int32", 4},
                                          {"uint", "uint32", 4},
                                          {"float", "float32", 4},
                                          {"double", "float64", 8}}};

std::optional<PlyType> type_named(std::string_view name) {
  for (std::size_t i = 0; i < kTypes.size(); ++i) {
    if (name == kTypes[i].name || name == kTypes[i].other_name) return static_cast<PlyType>(i);
  }
  return {};
}

class HeaderReader {
 public:
  HeaderReader(std::string_view bytes, const Limits& limits) : bytes_(bytes), limits_(limits) {}

  Result<PlyHeader> read() {
    if (auto ok = next_line(); !ok) return ok.error();
    if (next_word() != "ply") return fail(Cause::MalformedMesh, "a PLY file begins with \"ply\"");
    if (auto ok = next_line(); !ok) return ok.error();
    if (auto ok = read_format(); !ok) return ok.error();
    for (;;) {
      if (auto ok = next_line(); !ok) return ok.error();
      const std::string_view keyword = next_word();
      if (keyword == "end_header") break;
      if (keyword == "comment" || keyword == "obj_info") {
        header_.has_comments = true;
        continue;
      }
      Result<> ok;
      if (keyword == "element")
        ok = read_element();
      else if (keyword == "property")
        ok = read_property();
      else if (!keyword.empty())
        ok = fail(Cause::MalformedMesh, "the header holds " + quote(keyword) + ", which PLY does not know");
      if (!ok) return ok.error();
    }
    header_.end = at_;
    return std::move(header_);
  }

 private:
  /// Lines end as the first one does, so that a binary file may begin with a byte that ends lines elsewhere.
  Result<> next_line() {
    if (number_++ == 0) {
      const std::size_t first = bytes_.find_first_of("\r\n");
      const bool lone_return = first != std::string_view::npos && bytes_[first] == '\r' &&
                               (first + 1 == bytes_.size() || bytes_[first + 1] != '\n');
      line_end_ = lone_return ? '\r' : '\n';
    }
    const std::string_view rest = bytes_.substr(at_);
    const std::uint64_t most = limits_.max_line_bytes;
    const std::size_t end = rest.substr(0, most < rest.size() ? most + 1 : rest.size()).find(line_end_);
    if (end == std::string_view::npos) {
      if (rest.size() > most) {
        return fail(Cause::TooLarge,
                    "a line has more than " + std::to_string(most) + " bytes (max-line-bytes)");
      }
      return fail(Cause::MalformedMesh, "the file ends before \"end_header\"");
    }
    line_ = rest.substr(0, end);
    if (line_.ends_with('\r')) line_.remove_suffix(1);
    at_ += end + 1;
    return {};
  }

  std::string_view next_word() {
    const std::size_t begin = std::min(line_.find_first_not_of(" \t"), line_.size());
    line_.remove_prefix(begin);
    const std::string_view word = line_.substr(0, line_.find_first_of(" \t"));
    line_.remove_prefix(word.size());
    return word;
  }

  Result<> read_format() {
    const bool format = next_word() == "format";
    const std::string_view encoding = next_word(), version = next_word();
    if (encoding == "ascii")
      header_.encoding = PlyEncoding::Text;
    else if (encoding == "binary_little_endian")
      header_.encoding = PlyEncoding::LittleEndian;
    else if (encoding == "binary_big_endian")
      header_.encoding = PlyEncoding::BigEndian;
    else
      return fail(Cause::MalformedMesh,
                  "the second line must say the format: ascii, binary_little_endian "
                  "or binary_big_endian");
    if (!format) return fail(Cause::MalformedMesh, "the second line must begin with \"format\"");
    if (version != "1.0")
      return fail(Cause::UnsupportedFormat,
                  "the file has version " + quote(version) + " of PLY; 1.0 is known");
    return {};
  }

  Result<> read_element() {
    PlyElement element;
    element.name = next_word();
    element.line = number_;
    const std::string_view count = next_word();
    const auto [stop, failure] = std::from_chars(count.begin(), count.end(), element.count);
    if (element.name.empty() || failure != std::errc() || stop != count.end()) {
      return fail(Cause::MalformedMesh,
                  "element " + quote(element.name) + " has " + quote(count) + " rows, which is not a count");
    }
    if (header_.find(element.name) != header_.elements.size())
      return fail(Cause::MalformedMesh, "element " + quote(element.name) + " is declared twice");
    if (header_.elements.size() >= limits_.max_attributes) return too_many("elements");
    header_.elements.push_back(std::move(element));
    return {};
  }

  Result<> read_property() {
    if (header_.elements.empty())
      return fail(Cause::MalformedMesh, "a property is declared before any element");
    PlyElement& element = header_.elements.back();
    PlyProperty property;
    std::string_view type = next_word();
    if (type == "list") {
      type = next_word();
      property.count_type = type_named(type);
      if (!property.count_type) return unknown(type);
      if (is_real(*property.count_type))
        return fail(Cause::MalformedMesh,
                    "a list is counted with " + quote(type) + ", which is no whole number");
      type = next_word();
    }
    const auto known = type_named(type);
    if (!known) return unknown(type);
    property.type = *known;
    property.name = next_word();
    if (property.name.empty()) return fail(Cause::MalformedMesh, "a property has no name");
    if (element.find(property.name) != nullptr) {
      return fail(Cause::MalformedMesh,
                  "property " + quote(property.name) + " of " + quote(element.name) + " is declared twice");
    }
    if (properties_++ >= limits_.max_attributes) return too_many("properties");
    property.offset = element.least_bytes;
    const PlyType first = property.count_type.value_or(property.type);
    element.least_bytes += header_.encoding == PlyEncoding::Text ? 2 : size_of(first);
    element.has_list |= property.is_list();
    element.properties.push_back(std::move(property));
    return {};
  }

  Error unknown(std::string_view type) const {
    return fail(Cause::MalformedMesh, "a property has the type " + quote(type) + ", which PLY does not know");
  }

  Error too_many(const std::string& what) const {
    return fail(Cause::TooLarge, "the file has more than " + std::to_string(limits_.max_attributes) + ' ' +
                                     what + " (max-attributes)");
  }

  Error fail(Cause cause, const std::string& message) const {
    return {cause, message + " (line " + std::to_string(number_) + ')'};
  }

  std::string_view bytes_, line_;
  const Limits& limits_;
  std::uint64_t at_ = 0, number_ = 0;
  char line_end_ = '\n';
  std::uint64_t properties_ = 0;
  PlyHeader header_;
};

/// Calls visit(T{}) with the C++ type of a PLY type.
template <class Visit>
auto with_type(PlyType type, Visit&& visit) {
  switch (type) {
    case PlyType::Int8:
      return visit(std::int8_t{});
    case PlyType::Uint8:
      return visit(std::uint8_t{});
    case PlyType::Int16:
      return visit(std::int16_t{});
    case PlyType::Uint16:
      return visit(std::uint16_t{});
    case PlyType::Int32:
      return visit(std::int32_t{});
    case PlyType::Uint32:
      return visit(std::uint32_t{});
    case PlyType::Float32:
      return visit(float{});
    default:
      return visit(double{});
  }
}

}  // namespace

std::uint64_t size_of(PlyType type) { return kTypes[static_cast<std::size_t>(type)].size; }

std::string_view name_of(PlyType type) { return kTypes[static_cast<std::size_t>(type)].name; }

const PlyProperty* PlyElement::find(std::string_view wanted) const {
  const auto found = std::ranges::find(properties, wanted, &PlyProperty::name);
  return found == properties.end() ? nullptr : &*found;
}

std::size_t PlyHeader::find(std::string_view name) const {
  return static_cast<std::size_t>(std::ranges::find(elements, name, &PlyElement::name) - elements.begin());
}

Result<PlyHeader> read_ply_header(std::string_view bytes, const Limits& limits) {
  return HeaderReader(bytes, limits).read();
}

double load_real(const char* at, PlyType type, PlyEncoding encoding) {
  return with_type(
      type, [&](auto number) { return static_cast<double>(load_number<decltype(number)>(at, encoding)); });
}

std::int64_t load_integer(const char* at, PlyType type, PlyEncoding encoding) {
  return with_type(type, [&](auto number) -> std::int64_t {
    if constexpr (std::is_integral_v<decltype(number)>) return load_number<decltype(number)>(at, encoding);
    return 0;
  });
}

}  // namespace burnish
