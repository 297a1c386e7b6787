#include "core/io/pins.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <random>

#include "tests/support/shapes.h"

namespace burnish {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using namespace burnish::testing;

using Vertices = std::vector<Index>;

/// A document and the text that it reads from.
class Obj {
 public:
  explicit Obj(std::string text) : text_(std::make_unique<std::string>(std::move(text))) {
    auto decoded = decode(*text_, Format::Obj, {}, {});
    if (!decoded) {
      ADD_FAILURE() << decoded.error().message << " in\n" << *text_;
      std::abort();
    }
    document_ = std::move(*decoded);
  }
  const Document& operator*() const { return *document_; }
  const Document* operator->() const { return document_.get(); }

 private:
  std::unique_ptr<std::string> text_;
  std::unique_ptr<Document> document_;
};

/// Vertices for `faces` triangles, three of each triangle's own: a group's vertices then tell its faces.
std::string own_vertices(std::size_t faces) {
  std::string text;
  for (std::size_t i = 0; i < faces; ++i) {
    for (const char* rest : {" 0 0\n", " 1 0\n", " 0 1\n"}) text += "v " + std::to_string(i) + rest;
  }
  return text;
}

std::string face(std::size_t i) {
  return "f " + std::to_string(3 * i + 1) + ' ' + std::to_string(3 * i + 2) + ' ' + std::to_string(3 * i + 3);
}

/// `text` with every @ as the next triangle's statement.
std::string with_faces(const std::string& text) {
  std::string result = own_vertices(static_cast<std::size_t>(std::ranges::count(text, '@')));
  std::size_t next = 0;
  for (const char c : text) result += c == '@' ? face(next++) : std::string(1, c);
  return result;
}

/// Triangles of a group, for documents made with own_vertices().
Vertices faces_of(const Document& document, std::string_view group) {
  const auto vertices = document.group_vertices(group, {});
  if (!vertices) {
    ADD_FAILURE() << vertices.error().message;
    return {};
  }
  Vertices faces;
  for (std::size_t i = 0; i < vertices->size(); i += 3) {
    faces.push_back((*vertices)[i] / 3);
    for (Index c = 0; c < 3; ++c) EXPECT_EQ((*vertices)[i + c], 3 * faces.back() + c);
  }
  return faces;
}

TEST(ObjGroups, AreReadAsTheFileMeansThem) {
  struct Row {
    const char *text, *group;
    Vertices faces;
  };
  const Row rows[] = {
      {"@\ng a\n@\n", "default", {0}},
      {"@\ng a\n@\n", "a", {1}},
      {"g a b c\n@\ng b\n@\n", "a", {0}},
      {"g a b c\n@\ng b\n@\n", "b", {0, 1}},
      {"g a b c\n@\ng b\n@\n", "c", {0}},
      {"g a\n@\ng\n@\ng a\n@", "default", {1}},
      {"g a\n@\ng\n@\ng a\n@", "a", {0, 2}},
      {"g default\n@\n", "default", {0}},
      {"g a\ng b\n@\n", "a", {}},
      {"  g\ta \t\r\n@\r\n", "a", {0}},
      {"g a\r@\rg b\r@\r", "b", {1}},
      {"g a # b\n@\n", "a", {0}},
      {"g # a\n@\n", "default", {0}},
      {"g a#1\n@\n", "a#1", {0}},
      {"g a \\\n b\n@\n", "b", {0}},
      {"g a\\\r\nb\n@\n", "b", {0}},
      {"g a \\\n@\n", "a", {0}},
      {"g a \\\ng b\n@\ng b\n@", "a", {0}},  // the second g is a name
      {"\\\ng a\n@\n", "a", {0}},
      {"# no group: \\\ng a\n@\n", "a", {0}},
      {"G a\no a\ngroup a\ns a\nusemtl a\n#g a\n@\n", "default", {0}},
      {"g \xc3\xa4\n@\ng \xe4\n@\n", "\xe4", {1}},
      {"vn 0 0 \\\ng a\n@\n", "default", {0}},  // the normal goes on behind the backslash
      {"vn 0 # \\\ng a\n@\n", "a", {0}},
      {"v 9 \\\n 9 \\\n 9\ng a\n@\n", "a", {0}},
      {"@ # one \\\ng a\n@\n", "a", {1}},
      {"v 9 9 9 \\\ng a\n@\n", "a", {0}},
      {"f\\\n1 2 3\ng a\n@\n", "a", {0}},  // no face to the parser either
      {"g a\n@ # g b\n@ \\\n\ng b\n@\n", "a", {0, 1}},
      {"vt 0 \\\ng a\n@", "a", {0}},
  };
  for (const Row& row : rows) {
    const std::string text = with_faces(row.text);
    EXPECT_EQ(faces_of(*Obj(text), row.group), row.faces) << row.text << row.group;
  }
}

TEST(ObjGroups, TakePolygonsAndIndicesThatCountBackwards) {
  const Obj document(own_vertices(3) +
                     "g quad\nf 1 2 3 4\ng three\nf -3 -2 -1\n"
                     "g bent\nf 6/ 7// \\\n 5/ 6\n");
  EXPECT_THAT(*document->group_vertices("quad", {}), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(*document->group_vertices("three", {}), ElementsAre(6, 7, 8));
  EXPECT_THAT(*document->group_vertices("bent", {}), ElementsAre(4, 5, 6));
}

// The pass counts faces, the parser has read them: a statement that only one of them sees would shift all
// others.
TEST(ObjGroups, CountFacesAsTheParserDoes) {
  struct Line {
    const char* text;
    const char* group = nullptr;  // that begins here
  };
  const Line lines[] = {
      {"@\n"},
      {"  @ # g a\r\n"},
      {"@ \\\n\\\r\n \n"},
      {"\\\n\t@#\n"},
      {"g a\n", "a"},
      {"g b \\\n\n", "b"},
      {"g\n", "default"},
      {"g a \\\n@\n", "a"},
      {"vn 1\n"},
      {"vn \\\n f 1 2 3\n"},
      {"vn \\\ng a b\n"},
      {"vn 0 0 1 \\\n@\n"},
      {"v 1 2 \\\n3\n"},
      {"v 1 2 3 \\\n1 1 1 \\\n\n"},
      {"f\\\n\n"},
      {"fo 1 2 3\n"},
      {"# f 1 2 3\n"},
      {"# \\\n@\n"},
      {"l 1 2\n"},
      {"curv f 1 2 3\n"},
      {"vt 1 \\\n@\n"},
      {"\r\n\n"},
  };
  std::mt19937_64 random(7);
  for (int round = 0; round < 300; ++round) {
    std::string text = "g a\n@\ng b\n@\ng\n@\n", group = "default";
    std::map<std::string, Vertices> expected = {{"a", {0}}, {"b", {1}}, {"default", {2}}};
    Index faces = 3;
    for (int i = 0; i < 30; ++i) {
      const Line& line = lines[random() % std::size(lines)];
      text += line.text;
      if (line.group != nullptr) group = line.group;
      if (std::string_view(line.text).find('@') != std::string_view::npos) expected[group].push_back(faces++);
    }
    const std::string obj = with_faces(text);
    const Obj document(obj);
    ASSERT_EQ(document->triangles().size(), faces) << obj;
    for (const auto& [name, of_group] : expected)
      ASSERT_EQ(faces_of(*document, name), of_group) << name << obj;
  }
}

// Every line goes on behind its end: reading the names of each anew would take hours.
TEST(ObjGroups, ReadAMillionNamesOnce) {
  std::string text = own_vertices(1);
  for (int i = 0; i < 1'000'000; ++i) text += "g \\\n";
  const Obj document(text + "last\n" + face(0));
  EXPECT_EQ(faces_of(*document, "last"), Vertices{0});
}

TEST(ObjGroups, SurviveEveryTruncation) {
  const std::string text =
      own_vertices(2) + "g a b\\\r\n c\nvn 0 0 \\\n 1\nf 1//1 2//1 3//1\ng\nf -3 -2 -1 # last\ng a \\";
  std::size_t accepted = 0;
  for (std::size_t length = 0; length <= text.size(); ++length) {
    const auto decoded = decode(std::string_view(text).substr(0, length), Format::Obj, {}, {});
    if (!decoded) continue;
    ++accepted;
    for (const char* group : {"a", "b", "c", "default", "nobody"}) {
      const auto vertices = (*decoded)->group_vertices(group, {});
      if (vertices) {
        EXPECT_THAT(*vertices, ::testing::Each(::testing::Lt((*decoded)->positions().size())));
      } else {
        EXPECT_EQ(vertices.error().cause, Cause::BadOption) << length;
      }
    }
  }
  EXPECT_GT(accepted, 20U);
}

TEST(ObjGroups, NameThoseThatThereAre) {
  const Obj few(with_faces("@\ng left right\n@\n"));
  EXPECT_EQ(few->group_vertices("Left", {}).error(),
            (Error{Cause::BadOption, R"(the mesh has no group "Left"; it has "default", "left", "right")",
                   "pinned.group"}));
  std::string many;
  for (int i = 0; i < 12; ++i) many += "g part" + std::to_string(i % 10) + "\n@\n";
  const Error error = Obj(with_faces(many))->group_vertices("b\n", {}).error();
  EXPECT_THAT(error.message, HasSubstr(R"(no group "b?"; it has "part0", )"));
  EXPECT_THAT(error.message, ::testing::EndsWith(R"("part7" and more)"));
}

struct Pinned {
  Obj document;
  Surface surface;

  explicit Pinned(std::string text)
      : document(std::move(text)),
        surface(*prepare_surface(document->positions(), document->triangles(), {})) {}
  Result<std::uint32_t> pin(const PinOptions& options, const RunControl& run = {}) {
    return pin_vertices(*document, options, surface, run);
  }
  Vertices vertices() const {
    Vertices pinned;
    for (Index v = 0; v < surface.weld.size(); ++v) {
      if (surface.pinned[surface.weld[v]] != 0) pinned.push_back(v);
    }
    return pinned;
  }
};

TEST(PinVertices, PinsWhatAnyOptionNames) {
  Pinned mesh(with_faces("@\ng a\n@\ng b\n@\n@\n"));
  EXPECT_EQ(*mesh.pin({.vertices = {10, 0, 0}, .group = "a"}), 5U);
  EXPECT_THAT(mesh.vertices(), ElementsAre(0, 3, 4, 5, 10));
  EXPECT_EQ(*mesh.pin({.vertices = {11}}), 1U) << "what was pinned before is forgotten";
}

TEST(PinVertices, PinsNothingWhenNothingIsNamed) {
  Pinned mesh(with_faces("@\ng empty\n"));
  EXPECT_EQ(*mesh.pin({}), 0U);
  EXPECT_TRUE(mesh.surface.pinned.empty());
  EXPECT_EQ(*mesh.pin({.group = "empty"}), 0U);
}

TEST(PinVertices, PinsEveryVertexAtThePlace) {
  Pinned mesh("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\ng a\nf 1 2 3\ng b\nf 4 6 5\n");
  EXPECT_EQ(*mesh.pin({.vertices = {3}}), 2U);
  EXPECT_THAT(mesh.vertices(), ElementsAre(1, 3));
  EXPECT_EQ(*mesh.pin({.group = "a"}), 5U);
  EXPECT_THAT(mesh.vertices(), ElementsAre(0, 1, 2, 3, 4));
}

TEST(PinVertices, NamesWhatIsWrong) {
  Pinned mesh(with_faces("g a\n@\n"));
  EXPECT_EQ(mesh.pin({.vertices = {0, 2, 3}}).error(),
            (Error{Cause::BadOption, "pinned.vertices[2] is 3 but the mesh has 3 vertices, counted from 0",
                   "pinned.vertices[2]"}));
  EXPECT_EQ(mesh.pin({.vertices = {kNone}}).error().field, "pinned.vertices[0]");
  EXPECT_EQ(mesh.pin({.group = "b"}).error().field, "pinned.group");
  EXPECT_EQ(mesh.pin({.attribute = "a"}).error(),
            (Error{Cause::BadOption, "an OBJ has no attributes to pin by", "pinned.attribute"}));
}

TEST(PinVertices, StopsWhenAsked) {
  std::stop_source source;
  source.request_stop();
  const RunControl stopped{.stop = source.get_token()};
  Pinned mesh(with_faces("g a\n@\n"));
  EXPECT_EQ(mesh.pin({.vertices = {0}}, stopped).error().cause, Cause::Cancelled);
  EXPECT_EQ(mesh.pin({.group = "a"}, stopped).error().cause, Cause::Cancelled);
}

TEST(Quote, IsShortAndPrintable) {
  EXPECT_EQ(quote("a b\t\xff"), "\"a b??\"");
  EXPECT_EQ(quote(std::string(1000, 'x')).size(), 66U);
}

}  // namespace
}  // namespace burnish
