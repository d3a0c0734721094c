// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/junit.h"

#include <fmt/format.h>
#include <tinyxml2.h>

#include <algorithm>
#include <stdexcept>

namespace stroma::command {
namespace {

std::string printable(std::string text) {
  std::ranges::replace_if(
      text, [](char c) { return static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t'; }, '?');
  return text;
}

std::string firstLine(const std::string& text) { return text.substr(0, text.find('\n')); }

}  // namespace

void writeJunit(const std::string& suite, const std::vector<JunitCase>& cases, const std::string& file) {
  const auto failures = std::ranges::count_if(cases, [](const JunitCase& test) { return !test.failure.empty(); });
  double seconds = 0;
  for (const JunitCase& test : cases) seconds += test.seconds;

  tinyxml2::XMLDocument document;
  document.InsertEndChild(document.NewDeclaration());
  tinyxml2::XMLElement* root = document.NewElement("testsuite");
  document.InsertEndChild(root);
  root->SetAttribute("name", printable(suite).c_str());
  root->SetAttribute("tests", std::int64_t(cases.size()));
  root->SetAttribute("failures", std::int64_t(failures));
  root->SetAttribute("errors", 0);
  root->SetAttribute("skipped", 0);
  root->SetAttribute("time", fmt::format("{:.3f}", seconds).c_str());
  for (const JunitCase& test : cases) {
    tinyxml2::XMLElement* element = root->InsertNewChildElement("testcase");
    element->SetAttribute("classname", printable(suite).c_str());
    element->SetAttribute("name", printable(test.name).c_str());
    element->SetAttribute("time", fmt::format("{:.3f}", test.seconds).c_str());
    if (test.failure.empty()) continue;
    tinyxml2::XMLElement* failure = element->InsertNewChildElement("failure");
    failure->SetAttribute("message", printable(firstLine(test.failure)).c_str());
    failure->SetText(printable(test.failure).c_str());
  }
  if (document.SaveFile(file.c_str()) != tinyxml2::XML_SUCCESS)
    throw std::runtime_error(fmt::format("{}: cannot write", file));
}

}  // namespace stroma::command
