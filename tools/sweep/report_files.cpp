// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/report_files.h"

#include "tools/platform/text_file.h"

STROMA_TEXT_FILE(stroma_report_script, STROMA_REPORT_FOLDER "/report.js")
STROMA_TEXT_FILE(stroma_report_style, STROMA_REPORT_FOLDER "/report.css")
STROMA_TEXT_FILE(stroma_report_chart, STROMA_REPORT_FOLDER "/chart.css")
STROMA_TEXT_FILE(stroma_report_light, STROMA_REPORT_FOLDER "/light.css")
STROMA_TEXT_FILE(stroma_report_dark, STROMA_REPORT_FOLDER "/dark.css")

namespace stroma::sweep {
namespace {

/// Renderers of SVG files know no variables: their values are put in.
std::string withValues(std::string_view rules, std::string_view values) {
  std::string text(rules);
  for (std::size_t at = 0; (at = values.find("--", at)) != std::string_view::npos;) {
    const std::size_t colon = values.find(':', at), end = values.find(';', colon);
    const std::string name = "var(" + std::string(values.substr(at, colon - at)) + ")";
    std::size_t from = colon + 1;
    while (values[from] == ' ') ++from;
    const std::string value(values.substr(from, end - from));
    for (std::size_t found = text.find(name); found != std::string::npos; found = text.find(name, found + value.size()))
      text.replace(found, name.size(), value);
    at = end;
  }
  return text;
}

/// Without the licence line and the selector: only what lies between the braces.
std::string_view declarations(std::string_view file) {
  const std::size_t open = file.find('{'), close = file.rfind('}');
  return file.substr(open + 1, close - open - 1);
}

}  // namespace

std::string_view reportScript() { return stroma_report_script(); }

std::string_view reportStyle() {
  static const std::string all = [] {
    const std::string light(stroma_report_light()), dark(declarations(stroma_report_dark()));
    return light + "@media (prefers-color-scheme: dark){:root{" + dark + "}}\n:root[data-theme=light]{" +
           std::string(declarations(light)) + "}\n:root[data-theme=dark]{" + dark + "}\n" +
           std::string(stroma_report_chart()) + std::string(stroma_report_style());
  }();
  return all;
}

std::string chartStyle(bool dark) {
  const std::string_view rules = stroma_report_chart();
  std::string text = withValues(rules, declarations(stroma_report_light()));
  if (dark)
    text += "@media (prefers-color-scheme: dark){" + withValues(rules, declarations(stroma_report_dark())) + "}";
  return text;
}

}  // namespace stroma::sweep
