// Files with whatever properties in whatever order.
#include <algorithm>
#include <random>

#include "tests/core/ply_fixture.h"

namespace burnish::testing {
namespace {

constexpr PlyType kTypes[] = {PlyType::Int8,  PlyType::Uint8,  PlyType::Int16,   PlyType::Uint16,
                              PlyType::Int32, PlyType::Uint32, PlyType::Float32, PlyType::Float64};

struct Column {
  std::string name;
  PlyType type;
  bool list = false;
};

/// A made-up file, and for each of its bytes (of text: words) whether smoothing may change it.
class RandomPly {
 public:
  RandomPly(PlyEncoding encoding, unsigned seed) : rng_(seed), encoding_(encoding) {
    header_ = "ply\n" + format_line(encoding);
    add_spare(0);
    add_vertices();
    add_spare(1);
    add_faces();
    add_spare(2);
    bytes = header_ + "end_header\n" + body_;
    owned.insert(owned.begin(), (header_ + "end_header\n").size(), false);
  }

  std::string bytes;
  std::vector<bool> owned;  ///< per byte; of text, per byte of the file as it is before

 private:
  static constexpr int kSide = 4;

  int pick(int most) { return static_cast<int>(rng_() % static_cast<unsigned>(most + 1)); }

  std::vector<Column> spares(const std::string& prefix, int most) {
    std::vector<Column> columns;
    for (int i = pick(most); i > 0; --i)
      columns.push_back({prefix + std::to_string(i), kTypes[pick(7)], pick(3) == 0});
    return columns;
  }

  void declare(const std::string& name, int rows, const std::vector<Column>& columns) {
    if (pick(2) == 0) header_ += "comment about " + name + "\n";
    header_ += "element " + name + ' ' + std::to_string(rows) + '\n';
    for (const Column& c : columns) {
      header_ += c.list ? "property list uchar " : "property ";
      header_ += std::string(name_of(c.type)) + ' ' + c.name + '\n';
    }
  }

  void put(const Column& column, std::initializer_list<double> values, bool own) {
    PlyBody body(encoding_);
    if (column.list) body.put(PlyType::Uint8, static_cast<double>(values.size()));
    for (const double value : values) body.put(column.type, value);
    append(body.bytes() + (encoding_ == PlyEncoding::Text ? std::string(1 + pick(1), ' ') : ""), own);
  }

  void put_spare(const Column& column) {
    const auto number = [&] { return static_cast<double>(pick(100)); };
    if (!column.list) return put(column, {number()}, false);
    if (pick(1) == 0) return put(column, {number(), number(), number()}, false);
    put(column, {}, false);
  }

  void append(const std::string& text, bool own) {
    body_ += text;
    owned.insert(owned.end(), text.size(), own);
  }

  void end_row() {
    if (encoding_ == PlyEncoding::Text) append("\n", false);
  }

  void add_spare(int number) {
    const auto columns = spares("spare", 3);
    const int rows = columns.empty() ? 5 : pick(4);
    declare("element" + std::to_string(number), rows, columns);
    for (int row = 0; row < rows && !columns.empty(); ++row) {
      for (const Column& column : columns) put_spare(column);
      end_row();
    }
  }

  void add_vertices() {
    const PlyType type = pick(1) == 0 ? PlyType::Float32 : PlyType::Float64;
    std::vector<Column> columns = spares("extra", 5);
    for (const char* name : {"x", "y", "z"}) columns.push_back({name, type});
    if (pick(1) == 0) {
      for (const char* name : {"nx", "ny", "nz"}) columns.push_back({name, type});
    }
    std::shuffle(columns.begin(), columns.end(), rng_);
    declare("vertex", (kSide + 1) * (kSide + 1), columns);
    for (int y = 0; y <= kSide; ++y) {
      for (int x = 0; x <= kSide; ++x) {
        for (const Column& c : columns) {
          if (c.name == "x")
            put(c, {x * 0.5}, true);
          else if (c.name == "y")
            put(c, {y * 0.5}, true);
          else if (c.name == "z")
            put(c, {0.125 * pick(3)}, true);
          else if (c.name.size() == 2 && c.name[0] == 'n')
            put(c, {c.name == "nz" ? 1.0 : 0.0}, true);
          else
            put_spare(c);
        }
        end_row();
      }
    }
  }

  void add_faces() {
    std::vector<Column> columns = spares("more", 3);
    columns.push_back({pick(1) == 0 ? "vertex_index" : "vertex_indices", kTypes[pick(5)], true});
    std::shuffle(columns.begin(), columns.end(), rng_);
    declare("face", kSide * kSide, columns);
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        const double v = y * (kSide + 1) + x;
        for (const Column& c : columns) {
          if (c.name.starts_with("vertex"))
            put(c, {v, v + 1, v + kSide + 2, v + kSide + 1}, false);
          else
            put_spare(c);
        }
        end_row();
      }
    }
  }

  std::mt19937 rng_;
  PlyEncoding encoding_;
  std::string header_, body_;
};

/// Words and what stands between them.
std::vector<std::string> pieces(const std::string& text) {
  std::vector<std::string> result;
  for (const char c : text) {
    const bool blank = c == ' ' || c == '\n';
    if (result.empty() || blank != (result.back()[0] == ' ' || result.back()[0] == '\n'))
      result.emplace_back();
    result.back() += c;
  }
  return result;
}

TEST(PlyRandom, ComesBackByteForByteWhenNothingMoved) {
  for (const PlyEncoding encoding : kEncodings) {
    for (unsigned seed = 0; seed < 200; ++seed) {
      const RandomPly made(encoding, seed);
      const LoadedFile file(made.bytes);
      ASSERT_EQ(file.document->triangles().size(), 32U) << seed;
      ASSERT_EQ(file.written(), made.bytes) << seed;
    }
  }
}

TEST(PlyRandom, OnlyPositionsAndNormalsChange) {
  for (const PlyEncoding encoding : kEncodings) {
    for (unsigned seed = 0; seed < 200; ++seed) {
      const RandomPly made(encoding, seed);
      LoadedFile file(made.bytes);
      file.move_all();
      const std::string written = file.written();
      const LoadedFile again(written);
      expect_positions(*again.document, file.moved(), 1e-6);
      if (encoding != PlyEncoding::Text) {
        ASSERT_EQ(written.size(), made.bytes.size());
        for (std::size_t i = 0; i < written.size(); ++i)
          ASSERT_TRUE(made.owned[i] || written[i] == made.bytes[i]) << seed << " at " << i;
        continue;
      }
      const auto was = pieces(made.bytes), now = pieces(written);
      ASSERT_EQ(was.size(), now.size()) << seed;
      for (std::size_t i = 0, at = 0; i < was.size(); at += was[i++].size())
        ASSERT_TRUE(made.owned[at] || was[i] == now[i]) << seed << ": " << was[i];
    }
  }
}

TEST(PlyRandom, EveryPrefixIsAnErrorOrAMesh) {
  for (const PlyEncoding encoding : kEncodings) {
    for (unsigned seed = 0; seed < 10; ++seed)
      expect_prefixes_survive(RandomPly(encoding, seed).bytes, Format::Ply);
  }
}

}  // namespace
}  // namespace burnish::testing
