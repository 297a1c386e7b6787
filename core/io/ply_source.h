// Private to the PLY codec: values one after the other, of text or binary data.
#pragma once

#include "core/io/ply_header.h"
#include "core/io/text_scan.h"

namespace burnish {

/// Each function passes what it reads; false, and the cursor stands before it, when the data end or, of text,
/// when a word is no such number.
class PlyBinarySource {
 public:
  PlyBinarySource(std::string_view bytes, std::uint64_t begin, PlyEncoding encoding)
      : bytes_(bytes), at_(begin), encoding_(encoding) {}

  std::uint64_t offset() const { return at_; }

  bool integer(PlyType type, std::int64_t& value) {
    const std::uint64_t size = size_of(type);
    if (bytes_.size() - at_ < size) return false;
    value = load_integer(bytes_.data() + at_, type, encoding_);
    at_ += size;
    return true;
  }

  bool real(PlyType type, double& value) {
    const std::uint64_t size = size_of(type);
    if (bytes_.size() - at_ < size) return false;
    value = load_real(bytes_.data() + at_, type, encoding_);
    at_ += size;
    return true;
  }

  bool skip(PlyType type, std::uint64_t count) {
    const std::uint64_t size = size_of(type);
    if ((bytes_.size() - at_) / size < count) return false;
    at_ += size * count;
    return true;
  }

  /// Why the last function failed.
  Error problem(const std::string& where) const {
    return {Cause::MalformedMesh, "the file ends in " + where + place(at_)};
  }
  std::string place(std::uint64_t offset) const { return " (byte " + std::to_string(offset) + ')'; }

 private:
  std::string_view bytes_;
  std::uint64_t at_;
  PlyEncoding encoding_;
};

class PlyTextSource {
 public:
  PlyTextSource(std::string_view bytes, std::uint64_t begin, PlyEncoding)
      : bytes_(bytes), scanner_(bytes, begin, false) {}

  /// Of the next word.
  std::uint64_t offset() {
    scanner_.find_word();
    return scanner_.offset();
  }

  bool integer(PlyType, std::int64_t& value) { return scanner_.find_word() && scanner_.integer(value); }
  bool real(PlyType, double& value) { return scanner_.find_word() && scanner_.number(value); }
  std::string_view word() { return scanner_.word(); }
  bool skip(PlyType, std::uint64_t count) {
    for (; count > 0 && scanner_.find_word(); --count) scanner_.word();
    return count == 0;
  }

  Error problem(const std::string& where) {
    if (!scanner_.find_word())
      return {Cause::MalformedMesh, "the file ends in " + where + place(bytes_.size())};
    return scanner_.fail(Cause::MalformedMesh, where + ": " + scanner_.quoted() + " is not a number here");
  }
  std::string place(std::uint64_t offset) const { return line_place(bytes_, offset); }

 private:
  std::string_view bytes_;
  TextScanner scanner_;
};

/// Goes through a row: visit(property, count) passes the `count` values of each property, or returns false.
/// False where something did not fit; a negative count of a list is left in `count`.
template <class Source, class Visit>
bool read_ply_row(Source& source, const PlyElement& element, std::int64_t& count, Visit&& visit) {
  for (const PlyProperty& property : element.properties) {
    count = 1;
    if (property.is_list() && (!source.integer(*property.count_type, count) || count < 0)) return false;
    if (!visit(property, static_cast<std::uint64_t>(count))) return false;
  }
  return true;
}

/// Calls work(source) with the source that suits the encoding.
template <class Work>
auto with_ply_source(std::string_view bytes, std::uint64_t begin, PlyEncoding encoding, Work&& work) {
  if (encoding == PlyEncoding::Text) {
    PlyTextSource source(bytes, begin, encoding);
    return work(source);
  }
  PlyBinarySource source(bytes, begin, encoding);
  return work(source);
}

}  // namespace burnish
