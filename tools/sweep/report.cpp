// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "framework/scene/output_file.h"
#include "tools/platform/process.h"
#include "tools/session/xml_text.h"
#include "tools/sweep/cores.h"
#include "tools/sweep/report_files.h"

namespace stroma::sweep {
namespace {

namespace fs = std::filesystem;

std::string timeText(double seconds) { return numberText(seconds, Numbers::seconds); }

std::string errorText(const Findings& findings, const Entry& entry) {
  const Assessment& assessment = findings.assessment;
  const Numbers numbers = assessment.is_relative ? Numbers::share : Numbers::plain;
  if (entry.is_reference && assessment.expected > 0) return "about " + numberText(*entry.error, numbers);
  return numberText(*entry.error, numbers);
}

std::string frontList(const Findings& findings) {
  std::vector<const Entry*> front;
  for (const Entry& entry : findings.entries)
    if (entry.on_front) front.push_back(&entry);
  if (front.empty()) return "";
  std::ranges::sort(front, {}, [](const Entry* entry) { return entry->runs.medianOf(&Repetition::seconds); });
  std::string rows;
  for (const Entry* entry : front)
    rows += fmt::format(
        "<tr data-entry=\"{}\"><td class=\"number\">{}</td><td class=\"number\">{}</td><td>{}</td><td>{}</td></tr>\n",
        entry - findings.entries.data(), timeText(entry->runs.medianOf(&Repetition::seconds)),
        errorText(findings, *entry), xmlText(nameOf(findings.axes, entry->configuration)),
        fmt::format("<button class=\"copy\" data-text=\"{}\">copy the command</button>",
                    xmlText(commandLine(findings.request, entry->configuration))));
  return "<section><h2>The front: nothing is both faster and more accurate</h2><div class=\"scroll\"><table "
         "class=\"front-table\"><thead><tr>"
         "<th>time to the end</th><th>error</th><th>settings</th><th></th></tr></thead><tbody>" +
         rows + "</tbody></table></div></section>\n";
}

std::string failures(const Findings& findings) {
  std::string rows;
  for (const Entry& entry : findings.entries)
    if (!entry.runs.failure.empty())
      rows += fmt::format("<tr data-entry=\"{}\"><td>{}</td><td>{}</td><td>{}</td></tr>\n",
                          &entry - findings.entries.data(), xmlText(nameOf(findings.axes, entry.configuration)),
                          xmlText(entry.runs.outcome), xmlText(entry.runs.failure));
  if (rows.empty()) return "";
  return "<section><h2>Without a "
         "result</h2><div class=\"scroll\"><table><thead><tr><th>settings</th><th>outcome</th><th>why</th></tr></thead>"
         "<tbody>" +
         rows + "</tbody></table></div></section>\n";
}

std::string paragraphs(const Findings& findings) {
  const Assessment& assessment = findings.assessment;
  const auto good = std::ranges::count_if(findings.entries, [](const Entry& entry) { return entry.error.has_value(); });
  std::string text = fmt::format("<p><strong>{} configurations, {} with a result.</strong> The reference is {}",
                                 findings.entries.size(), good, xmlText(assessment.reference));
  if (assessment.isUncertain())
    text += fmt::format("; <strong>{}</strong>, and so is every error",
                        knownTo(assessment, numberText(assessment.uncertainty,
                                                       assessment.is_relative ? Numbers::share : Numbers::plain)));
  text += assessment.is_relative ? ". Errors are shares of the reference.</p>\n"
                                 : ". Errors have the reference's unit.</p>\n";
  if (!findings.goal.empty()) text += fmt::format("<p class=\"goal\">{}</p>\n", xmlText(findings.goal));
  std::string items;
  for (const AxisEstimate& axis : assessment.axes)
    items +=
        fmt::format("<li>{}: {}{} ({})</li>\n", xmlText(findings.axes[axis.axis].label()),
                    axis.order ? fmt::format("order {:.2f}, ", *axis.order) : "",
                    numberText(axis.uncertainty, assessment.is_relative ? Numbers::share : Numbers::plain), axis.how);
  for (const std::string& note : assessment.notes) items += fmt::format("<li>{}</li>\n", xmlText(note));
  if (findings.not_run > 0)
    items += fmt::format("<li>{} configurations of the grid were not needed and not run</li>\n", findings.not_run);
  const auto disturbed =
      std::ranges::count_if(findings.entries, [](const Entry& entry) { return entry.runs.wereDisturbed(); });
  if (disturbed > 0)
    items += fmt::format(
        "<li>{} configurations were timed on a busy machine: other programs had their core for more than a "
        "tenth of a run</li>\n",
        disturbed);
  return text + (items.empty() ? "" : "<ul class=\"notes\">" + items + "</ul>\n");
}

std::string foot(const Findings& findings) {
  return fmt::format(
      "<footer><p>{}</p><p>Build {} · runs in an order by seed {} · {} of each, the median counts · timed runs alone "
      "on "
      "their cores</p><pre>{}</pre></footer>\n",
      xmlText(machineText()), findings.build, findings.request.seed,
      findings.request.timed ? findings.request.repeat : 1, xmlText(commandLine(findings.request)));
}

/// Inside of a script element.
std::string embedded(const nlohmann::ordered_json& json) {
  std::string text = json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace), out;
  for (const char c : text) out += c == '<' ? std::string("\\u003c") : std::string(1, c);
  return out;
}

constexpr int not_installed = 127;

/// The exit code of the program that makes the picture.
int makePicture(const std::string& svg, const std::string& png) try {
  return exitCodeOf(start({{"rsvg-convert", "--zoom=2", "--output", png, svg}}));
} catch (const std::system_error&) {
  return not_installed;
}

}  // namespace

std::string pageOf(const Findings& findings, const std::vector<Chart>& charts) {
  const std::string name = fs::path(findings.request.scene).filename().string();
  std::string page = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\">\n<title>Sweep of "
      "{}</title>\n<style>\n{}</style>\n</head>\n<body>\n",
      xmlText(name), reportStyle());
  page += fmt::format(
      "<header><h1>Sweep of {}</h1><button id=\"theme\" title=\"light or dark (t)\">light / dark</button>"
      "</header>\n<main>\n<section>{}</section>\n",
      xmlText(name), paragraphs(findings));
  page +=
      "<p class=\"help\">Click a point for its command line. Tab reaches the charts, the arrow keys go from point to "
      "point, Enter copies the command, Esc closes.</p>\n<div class=\"charts\">\n";
  for (const Chart& chart : charts) page += "<figure>" + svgOf(chart, false, false) + "</figure>\n";
  page += "</div>\n" + frontList(findings) + failures(findings);
  page += "<section><h2>All configurations</h2><div class=\"scroll\"><table id=\"all\"></table></div></section>\n";
  page += foot(findings) +
          "</main>\n<aside id=\"details\" hidden aria-live=\"polite\"></aside><div id=\"tip\" hidden></div>\n";
  page += fmt::format(
      "<script type=\"application/json\" id=\"data\">{}</script>\n<script>\n{}</script>\n</body>\n</html>\n",
      embedded(jsonOf(findings)), reportScript());
  return page;
}

Written writeReport(const Findings& findings) {
  Written written;
  const auto write = [&](const std::string& name, const std::string& text) {
    const std::string file = (fs::path(findings.request.folder) / name).string();
    writeWholeFile(file, text);
    written.files.push_back(name);
    return file;
  };
  write("table.csv", csvOf(findings));
  write("table.json", jsonOf(findings).dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
  const std::vector<Chart> charts = chartsOf(findings);
  write("report.html", pageOf(findings, charts));
  int code = 0;
  for (const Chart& chart : charts) {
    const std::string plain = write(chart.id + ".svg", svgOf(chart, true, false));
    const std::string picture = fs::path(plain).replace_extension(".png").string();
    if (code == 0) code = makePicture(plain, picture);
    if (code == 0) written.files.push_back(chart.id + ".png");
    writeWholeFile(plain, svgOf(chart, true, true));
  }
  if (code == not_installed)
    written.notes.push_back("no .png: rsvg-convert is missing (package librsvg2-bin); the .svg files are there");
  else if (code != 0)
    written.notes.push_back("not every .png: rsvg-convert has failed; the .svg files are there");
  return written;
}

}  // namespace stroma::sweep
