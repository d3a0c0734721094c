// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fmt/format.h>

#include <array>
#include <filesystem>

#include "tools/session/xml_text.h"
#include "tools/stress/table.h"

namespace stroma::stress {
namespace {

constexpr const char* style = R"(
:root{--back:#fff;--text:#1b1f24;--weak:#667;--line:#d8dce2;--bad:#b3261e;--good:#1a7f37}
@media (prefers-color-scheme:dark){:root{--back:#15181d;--text:#e6e8eb;--weak:#99a;--line:#333a44;--bad:#ff8a80;--good:#7ddc92}}
body{font:15px/1.5 system-ui,sans-serif;max-width:70em;margin:2em auto;padding:0 1em;background:var(--back);color:var(--text)}
table{border-collapse:collapse;margin:1em 0}td,th{padding:.25em .8em;border-bottom:1px solid var(--line);text-align:right}
td:first-child,th:first-child{text-align:left}.none{color:var(--weak)}.breaks{color:var(--bad);font-weight:600}
.good{color:var(--good)}summary{cursor:pointer;padding:.3em 0}code{font-size:13px}li{margin:.4em 0}.weak{color:var(--weak)}
)";

constexpr std::array<const char*, endings> meanings = {
    "back at the shape of the undisturbed run, or the checked property holds",
    "finite to the last step and without a doubt; not, or not yet, at the undisturbed shape",
    "at rest in another shape, indistinguishable from a right one",
    "finite to the last step, with a sentence why it may be no result",
    "refused or stopped, with a sentence that names a component or a line of the scene",
    "took longer than a case may",
    "a crash, a standstill, a number that is not finite, a stop without a sentence, or a promise that is broken"};

std::string tableRows(const Findings& findings) {
  std::vector<std::string> groups;
  std::map<std::string, std::array<long, endings>> counts;
  for (const Result& result : findings.results) {
    if (!counts.contains(result.what.group)) groups.push_back(result.what.group);
    ++counts[result.what.group][std::size_t(result.outcome.ending)];
  }
  std::string text;
  for (const std::string& group : groups) {
    text += "<tr><td>" + xmlText(group) + "</td>";
    for (std::size_t e = 0; e < endings; ++e) {
      const long count = counts[group][e];
      text += fmt::format("<td class=\"{}\">{}</td>", count ? wordOf(Ending(e)) : "none", count);
    }
    text += "</tr>\n";
  }
  return text;
}

std::string details(const Findings& findings, Ending ending) {
  std::string text;
  for (const Like& like : alike(findings, ending)) {
    text += fmt::format("<details{}><summary>{} case{}{}{}</summary><ul>\n", ending == Ending::breaks ? " open" : "",
                        like.cases.size(), like.cases.size() == 1 ? "" : "s", like.sentence.empty() ? "" : ": ",
                        xmlText(like.sentence));
    for (const Result* one : like.cases) {
      text += fmt::format("<li>case {}: {}<br><code>{}</code>", one->what.number, xmlText(one->what.text),
                          xmlText(commandOf(findings.request, findings.steps, one->what.number)));
      for (std::size_t k = 1; k < one->outcome.sentences.size(); ++k)
        text += "<br><span class=\"weak\">" + xmlText(one->outcome.sentences[k]) + "</span>";
      text += "</li>\n";
    }
    text += "</ul></details>\n";
  }
  return text;
}

}  // namespace

std::string pageOf(const Findings& findings) {
  const std::string name = std::filesystem::path(findings.request.scene).filename().string();
  std::string text = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>stress of "
      "{0}</title>\n<style>{1}</style>"
      "</head><body>\n<h1>What {0} bears</h1>\n<p>{2} cases of {3} steps, seed {4}.{5}</p>\n",
      xmlText(name), style, findings.results.size(), findings.steps, findings.request.seed,
      findings.open ? fmt::format(" {} more are open: the same command goes on.", findings.open) : "");
  text += "<table><tr><th></th>";
  for (int e = 0; e < endings; ++e)
    text += fmt::format("<th title=\"{}\">{}</th>", meanings[std::size_t(e)], wordOf(Ending(e)));
  text += "</tr>\n" + tableRows(findings) + "</table>\n<dl class=\"weak\">";
  for (int e = 0; e < endings; ++e)
    text += fmt::format("<dt>{}</dt><dd>{}</dd>", wordOf(Ending(e)), meanings[std::size_t(e)]);
  text += "</dl>\n";
  for (const std::string& doubt : findings.doubts)
    text += "<p>The undisturbed run is in doubt: " + xmlText(doubt) + "</p>\n";
  for (const Ending ending : {Ending::breaks, Ending::elsewhere, Ending::doubt, Ending::stops, Ending::unfinished,
                              Ending::runs, Ending::good}) {
    const std::string part = details(findings, ending);
    if (!part.empty()) text += fmt::format("<h2 class=\"{0}\">{0}</h2>\n{1}", wordOf(ending), part);
  }
  return text + "</body></html>\n";
}

}  // namespace stroma::stress
