// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/junit.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "framework/scene/output_file.h"
#include "tools/session/xml_text.h"

namespace stroma::command {
namespace {

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
                xmlText(suite), cases.size(), failures, seconds);
  for (const JunitCase& test : cases) {
    stream << fmt::format("  <testcase classname=\"{}\" name=\"{}\" time=\"{:.3f}\"", xmlText(suite),
                          xmlText(test.name), test.seconds);
    if (test.failure.empty())
      stream << "/>\n";
    else
      stream << fmt::format(">\n    <failure message=\"{}\">{}</failure>\n  </testcase>\n",
                            xmlText(firstLine(test.failure)), xmlText(test.failure));
  }
  stream << "</testsuite>\n";
  writeWholeFile(file, stream.str());
}

}  // namespace stroma::command
