// Every method, by name, with its parameters. This table alone drives ListMethods, GET /v1/methods, the
// command line's help and docs/algorithms.md: add a method in its own pair of files and name it in
// registry.cpp.
#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/measure/noise_estimate.h"
#include "core/mesh/surface.h"

namespace burnish {

/// A number, an integer, or one of a parameter's choices.
using ParameterValue = std::variant<double, std::int64_t, std::string>;

enum class ParameterKind : std::uint8_t { Number, Integer, Choice };

struct ParameterSpec {
  std::string name;
  ParameterKind kind = ParameterKind::Number;
  ParameterValue default_value = {};
  double minimum = 0, maximum = 0;        ///< inclusive; for numbers and integers
  std::vector<std::string> choices = {};  ///< for choices
  std::string unit = {};                  ///< "mean edge lengths", "1" when it has none, "" for choices
  std::string text = {};                  ///< one or two sentences
};

/// Values by name. After resolve_parameters() every parameter of the method is present, in range.
class ParameterValues {
 public:
  std::map<std::string, ParameterValue> values;

  double number(const std::string& name) const { return std::get<double>(values.at(name)); }
  std::int64_t integer(const std::string& name) const { return std::get<std::int64_t>(values.at(name)); }
  const std::string& choice(const std::string& name) const { return std::get<std::string>(values.at(name)); }
};

/// What a method that chooses for its caller chose.
struct MethodChoice {
  std::string method;
  std::map<std::string, ParameterValue> parameters;  ///< those that are not the method's defaults
  double sharp_bending = 0;                          ///< share_of_sharp_bending() of the result
  std::string reason;                                ///< a sentence
};

/// What a run did beside moving vertices.
struct SmoothOutcome {
  std::uint32_t iterations = 0;  ///< that were completed
  std::vector<Warning> warnings;
  std::optional<MethodChoice> choice = {};  ///< set by `auto`
  std::optional<NoiseEstimate> noise = {};  ///< of the mesh as it was, by a method that looks at it
};

/// Bytes that a run takes beside the surface, at the most, whatever its parameters;
/// tests/core/memory_test.cpp measures them.
struct WorkMemory {
  std::uint32_t per_vertex = 0, per_triangle = 0;
  /// Also per triangle, but for the first kPart triangles only: of methods that work part by part.
  std::uint32_t per_triangle_of_part = 0;

  static constexpr std::uint64_t kPart = 250'000;
  std::uint64_t bytes(std::uint64_t vertices, std::uint64_t triangles) const {
    return per_vertex * vertices + per_triangle * triangles +
           per_triangle_of_part * std::min(triangles, kPart);
  }
};

struct Method {
  std::string name;                       ///< "adaptive"
  std::string summary;                    ///< one sentence
  std::string reference;                  ///< the paper, as cited
  std::string formula;                    ///< plain text, for docs/algorithms.md
  std::vector<ParameterSpec> parameters;  ///< its own, then the common ones
  WorkMemory work_memory = {};
  double nanoseconds = 0;  ///< per triangle and iteration with the defaults, on one core; roughly
  /// Moves surface.mesh.positions, never anything else. On an error the mesh is as it was.
  /// Errors: Cancelled, DeadlineExceeded, OutOfMemory.
  std::function<Result<SmoothOutcome>(Surface&, const ParameterValues&, const RunControl&)> run;
};

/// In the order to show them; the first is the default.
std::span<const Method> methods();

/// "" gives the default method. Errors: UnknownMethod, naming those that exist.
Result<const Method*> find_method(std::string_view name);

/// Of the method of that name; of a name that is none, the most of all.
WorkMemory work_memory_of(std::string_view name);

/// Roughly, on one core, with the method's own number of iterations unless one is given; of a name that is
/// none, 0.
double seconds_of(std::string_view name, std::uint64_t triangles, std::optional<double> iterations);

/// Reads one value from text, as a query string or --set gives it. Errors: UnknownOption, BadOption.
Result<ParameterValue> parse_parameter(const Method& method, std::string_view name, std::string_view text);

/// Checks names, types and ranges, and fills in defaults. A double without fraction serves as an integer.
/// Errors: UnknownOption, BadOption; Error::field is the parameter's name.
Result<ParameterValues> resolve_parameters(const Method& method,
                                           const std::map<std::string, ParameterValue>& given);

/// The methods as a section of Markdown: summary, reference, formula, table of parameters.
std::string methods_markdown();

}  // namespace burnish
