// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/junit.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "framework/scene/output_file.h"

namespace stroma::command {
namespace {

/// As the text of an attribute or an element.
std::string asXmlText(const std::string& text) {
  std::string out;
  for (const char c : text) {
    const bool is_control = static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t';
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else
      out += is_control ? '?' : c;
  }
  return out;
}

std::string firstLine(const std::string& text) { return text.substr(0, text.find('\n')); }

}  // namespace

void writeJunit(const std::string& suite, const std::vector<JunitCase>& cases, const std::string& file) {
  const auto failures = std::ranges::count_if(cases, [](const JunitCase& test) { return !test.failure.empty(); });
  double seconds = 0;
  for (const JunitCase& test : cases) seconds += test.seconds;
  std::ostringstream stream;
  stream << "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
         << fmt::format(
                "<testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"0\" skipped=\"0\" time=\"{:.3f}\">\n",
                asXmlText(suite), cases.size(), failures, seconds);
  for (const JunitCase& test : cases) {
    stream << fmt::format("  <testcase classname=\"{}\" name=\"{}\" time=\"{:.3f}\"", asXmlText(suite),
                          asXmlText(test.name), test.seconds);
    if (test.failure.empty())
      stream << "/>\n";
    else
      stream << fmt::format(">\n    <failure message=\"{}\">{}</failure>\n  </testcase>\n",
                            asXmlText(firstLine(test.failure)), asXmlText(test.failure));
  }
  stream << "</testsuite>\n";
  writeWholeFile(file, stream.str());
}

}  // namespace stroma::command
