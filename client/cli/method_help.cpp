#include "client/cli/method_help.h"

#include <sstream>

namespace burnish::cli {

std::string default_text(const ParameterSpec& spec) {
  std::ostringstream out;
  std::visit([&out](const auto& value) { out << value; }, spec.default_value);
  return out.str();
}

std::string range_text(const ParameterSpec& spec) {
  std::ostringstream out;
  if (spec.kind == ParameterKind::Choice) {
    for (const std::string& choice : spec.choices)
      out << (&choice == &spec.choices.front() ? "" : "|") << choice;
  } else {
    out << spec.minimum << " to " << spec.maximum;
    if (!spec.unit.empty() && spec.unit != "1") out << " " << spec.unit;
  }
  return out.str();
}

std::string method_help() {
  std::ostringstream out;
  for (const Method& method : methods()) {
    out << method.name << (&method == &methods().front() ? " (default)" : "") << ": " << method.summary
        << "\n  " << method.reference << "\n";
    for (const ParameterSpec& spec : method.parameters) {
      out << "    " << spec.name << "=" << default_text(spec) << "  (" << range_text(spec) << ")  "
          << spec.text << "\n";
    }
  }
  return out.str();
}

}  // namespace burnish::cli
