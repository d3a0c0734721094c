// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/report_files.h"

// NAME_begin and NAME_end: the bytes of a file of report/.
#define STROMA_REPORT_FILE(name, file)                                                             \
  asm(".section .rodata\n.global " #name "_begin\n.global " #name "_end\n.balign 16\n" #name       \
      "_begin:\n.incbin \"" STROMA_REPORT_FOLDER "/" file "\"\n" #name "_end:\n.byte 0\n.text\n"); \
  extern "C" __attribute__((visibility("hidden"))) const char name##_begin[], name##_end[];

STROMA_REPORT_FILE(stroma_report_script, "report.js")
STROMA_REPORT_FILE(stroma_report_style, "report.css")
STROMA_REPORT_FILE(stroma_report_chart, "chart.css")
STROMA_REPORT_FILE(stroma_report_light, "light.css")
STROMA_REPORT_FILE(stroma_report_dark, "dark.css")

namespace stroma::sweep {
namespace {

std::string_view between(const char* begin, const char* end) { return {begin, std::size_t(end - begin)}; }

#define STROMA_BYTES_OF(name) between(name##_begin, name##_end)

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

std::string_view reportScript() { return STROMA_BYTES_OF(stroma_report_script); }

std::string_view reportStyle() {
  static const std::string all = [] {
    const std::string light(STROMA_BYTES_OF(stroma_report_light)),
        dark(declarations(STROMA_BYTES_OF(stroma_report_dark)));
    return light + "@media (prefers-color-scheme: dark){:root{" + dark + "}}\n:root[data-theme=light]{" +
           std::string(declarations(light)) + "}\n:root[data-theme=dark]{" + dark + "}\n" +
           std::string(STROMA_BYTES_OF(stroma_report_chart)) + std::string(STROMA_BYTES_OF(stroma_report_style));
  }();
  return all;
}

std::string chartStyle(bool dark) {
  const std::string_view rules = STROMA_BYTES_OF(stroma_report_chart);
  std::string text = withValues(rules, declarations(STROMA_BYTES_OF(stroma_report_light)));
  if (dark)
    text += "@media (prefers-color-scheme: dark){" +
            withValues(rules, declarations(STROMA_BYTES_OF(stroma_report_dark))) + "}";
  return text;
}

}  // namespace stroma::sweep
