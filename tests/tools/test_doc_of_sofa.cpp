// SPDX-License-Identifier: LGPL-2.1-or-later
// What `stroma doc` says of SOFA's ways: each quirk is on the page of each component that it changes, with an attribute that the component
// has and a value that it takes; and what becomes of SOFA's attributes.
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "framework/scene/modules.h"
#include "tests/support/shell.h"
#include "tools/sofa/declared_attributes.h"
#include "tools/sofa/quirks.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using DocOfSofa = CommandTest;

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

std::vector<std::string> wordsOf(std::string_view text) {
  std::istringstream in{std::string(text)};
  return {std::istream_iterator<std::string>(in), {}};
}

/// Components by type, with all modules open.
std::map<std::string, std::unique_ptr<Component>> everyComponent() {
  Factory factory;
  Modules modules(factory);
  std::map<std::string, std::unique_ptr<Component>> all;
  for (const auto& entry : modules.index()) {
    const std::string type(entry.type);
    EXPECT_TRUE(modules.provide(type)) << type;
    all[type] = factory.make(type);
  }
  return all;
}

TEST_F(DocOfSofa, EachQuirkHasAttributesThatExistAndTakeItsValues) {
  const auto all = everyComponent();
  std::size_t parts = 0;
  for (const sofa::Quirk& quirk : sofa::allQuirks()) {
    EXPECT_FALSE(quirk.parts.empty()) << quirk.name;
    for (const sofa::QuirkPart& part : quirk.parts) {
      std::size_t concerned = 0;
      for (const auto& [type, component] : all) {
        if (!sofa::concerns(part, type, component->data())) continue;
        ++concerned;
        Data* data = component->data().find(part.attribute);
        ASSERT_TRUE(data) << quirk.name << ": " << type << "." << part.attribute;
        if (part.value.empty() || data->link()) continue;
        const auto problem = data->parse(std::string(part.value), DataOrigin::written);
        EXPECT_FALSE(problem) << quirk.name << ": " << type << "." << part.attribute << ": " << problem->message;
      }
      const std::size_t named = part.types == "*" ? 1 : wordsOf(part.types).size();
      EXPECT_TRUE(part.types == "Node" || concerned >= named) << quirk.name << ": " << part.types;
      parts += concerned;
    }
  }
  EXPECT_GT(parts, 100u);
}

TEST_F(DocOfSofa, TheAttributesThatTheDialectSetsAreThoseOfTheirQuirk) {
  const std::regex call("setQuirk\\(\\w+, \"([a-z-]+)\",\\s*\"(\\w+)\"");
  std::size_t calls = 0;
  for (const auto& entry : std::filesystem::directory_iterator(STROMA_SOURCE_DIR "/tools/sofa")) {
    if (entry.path().extension() != ".cpp") continue;
    const std::string text = readText(entry.path());
    for (std::sregex_iterator at(text.begin(), text.end(), call), end; at != end; ++at, ++calls) {
      const std::string name = (*at)[1], attribute = (*at)[2];
      bool found = false;
      for (const sofa::Quirk& quirk : sofa::allQuirks())
        for (const sofa::QuirkPart& part : quirk.parts) found = found || (quirk.name == name && part.attribute == attribute);
      EXPECT_TRUE(found) << entry.path() << ": " << name << " sets " << attribute;
    }
  }
  EXPECT_GT(calls, 40u);
}

TEST_F(DocOfSofa, PagesOfComponentsNameEachQuirk) {
  std::map<std::string, std::vector<std::pair<std::string, std::string>>> told;  // by type: quirk and attribute
  for (const sofa::Quirk& quirk : sofa::allQuirks()) {
    const Finished page = stroma("doc " + std::string(quirk.name));
    EXPECT_EQ(page.code, 0) << quirk.name;
    EXPECT_TRUE(has(page.out, std::string(quirk.what)) && has(page.out, "--without-quirk " + std::string(quirk.name))) << page.out;
    for (const sofa::QuirkPart& part : quirk.parts) {
      EXPECT_TRUE(has(page.out, std::string(part.attribute))) << page.out;
      const std::string attribute = std::string(part.attribute) + (part.value.empty() ? "\n" : "=\"" + std::string(part.value) + "\"\n");
      if (part.types == "*") told["SpringForceField"];  // and others
      if (part.types != "*" && part.types != "Node")
        for (const std::string& type : wordsOf(part.types)) told[type].emplace_back(quirk.name, attribute);
    }
  }
  for (const auto& [type, ways] : told) {
    const std::string page = stroma("doc " + type).out;
    EXPECT_TRUE(has(page, "SOFA's way, which scenes in its dialect have unless --without-quirk NAME leaves it out:")) << type;
    for (const auto& [quirk, attribute] : ways)
      EXPECT_TRUE(has(page, "\n  " + quirk + ": ") && has(page, "      " + attribute)) << type << ": " << quirk << "\n" << page;
  }
  EXPECT_TRUE(has(stroma("doc SpringForceField").out, "explicit-damping: ")) << "an attribute of many components";
  EXPECT_FALSE(has(stroma("doc OBJExporter").out, "SOFA's way")) << "which has none";
}

TEST_F(DocOfSofa, EverySofaAttributeIsReadWithoutEffectOrRefused) {
  const auto all = everyComponent();
  std::size_t read = 0, no_effect = 0, refused = 0, types = 0;
  for (const std::string_view type : sofa::declaringTypes()) {
    std::set<std::string_view> names;
    for (const sofa::DeclaredAttribute& attribute : sofa::declaredAttributes(type)) {
      EXPECT_TRUE(names.insert(attribute.name).second || attribute.name == "rayleighStiffness") << type << " twice: " << attribute.name;
      EXPECT_EQ(sofa::findDeclared(type, attribute.name)->name, attribute.name);
    }
    const auto here = all.find(std::string(sofa::componentFor(type)));
    if (here == all.end()) continue;
    ++types;
    for (const std::string_view name : names) {
      const sofa::Treatment treatment = sofa::treatmentOf(type, name, here->second->data());
      read += treatment == sofa::Treatment::read, no_effect += treatment == sofa::Treatment::no_effect;
      refused += treatment == sofa::Treatment::refused;
    }
  }
  EXPECT_GE(types, 90u);
  EXPECT_GT(read, 5 * refused);
  const std::string list = stroma("list --sofa").out;
  for (const std::string& line : {std::to_string(types) + " components of SOFA with ", std::to_string(read) + "  read\n",
                                  std::to_string(no_effect) + "  without effect\n", std::to_string(refused) + "  refused unless"})
    EXPECT_TRUE(has(list, line)) << line << "\n" << list;
  const std::string row = "| " + std::to_string(types) + " | " + std::to_string(read + no_effect + refused) + " | " + std::to_string(read) +
                          " | " + std::to_string(no_effect) + " | " + std::to_string(refused) + " |\n";
  EXPECT_TRUE(has(readText(STROMA_SOURCE_DIR "/docs/tutorials/sofa.md"), row)) << "the page of SOFA has not " << row;
  const std::string page = stroma("doc UniformMass").out;
  EXPECT_TRUE(has(page, "may have without effect:\n  ")) << page;
  EXPECT_TRUE(has(stroma("doc FixedLagrangianConstraint").out, "refused unless they have their default:\n  endTime (-1)"));
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
