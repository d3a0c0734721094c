// SPDX-License-Identifier: LGPL-2.1-or-later
// Values written back into the text of a scene: the value is the new one, and every other byte is the old one.
#include <gtest/gtest.h>

#include <random>

#include "framework/scene/load.h"
#include "tests/support/scene_fixture.h"
#include "tools/scene_writer/scene_text.h"

namespace stroma {
namespace STROMA_TEST_FILE {

using test::expectContains;

NodeDescription read(const std::string& text) {
  Diagnostics diagnostics;
  NodeDescription root = readXml(text, "scene.xml", {}, diagnostics);
  EXPECT_FALSE(diagnostics.hasErrors()) << diagnostics.text() << "\n" << text;
  return root;
}

TextPosition at(const SourceLocation& where) { return {where.line, where.column}; }

/// `text` with "HERE" where the only change is to be, in a text with one element `A` that has the attribute `k`.
std::string change(const std::string& text, const std::string& value, const std::string& attribute = "k") {
  return changedText(text, {{at(read(text).components.at(0).where), attribute, value}});
}

TEST(SceneText, OnlyTheValueChanges) {
  const std::string before =
                        "<?xml version=\"1.0\"?>\n<!-- k=\"0\" <A k='0'/> -->\n<Node>\r\n\t<A  j = '1'\n   k\t=\n '",
                    after = "'  l=\"3\"  />\n  <A k='5'/>\n</Node>  \n<!-- end -->";
  EXPECT_EQ(change(before + "2" + after, "2e3"), before + "2e3" + after);
  EXPECT_EQ(change(before + "2" + after, "2"), before + "2" + after);
  EXPECT_EQ(change(before + "2" + after, ""), before + after);
}

TEST(SceneText, WithoutChangesEveryByteStays) {
  for (const std::string& text :
       {"<Node>\r\n<A k='&lt;&#10;\t'/>\r\n</Node>\r\n", "\xEF\xBB\xBF<Node><A/></Node>", "<Node/>"})
    EXPECT_EQ(changedText(text, {}), text);
}

TEST(SceneText, AMissingAttributeFollowsTheLastOneOfItsTag) {
  EXPECT_EQ(change("<Node><A/></Node>", "1"), "<Node><A k=\"1\"/></Node>");
  EXPECT_EQ(change("<Node><A /></Node>", "1"), "<Node><A k=\"1\" /></Node>");
  EXPECT_EQ(change("<Node><A></A></Node>", "1"), "<Node><A k=\"1\"></A></Node>");
  EXPECT_EQ(change("<Node><A j='a/b>c'\n  /></Node>", "1"), "<Node><A j='a/b>c' k=\"1\"\n  /></Node>");
  EXPECT_EQ(change("<Node><A\n  j='1'\n  kk='2'\n></A></Node>", "1"),
            "<Node><A\n  j='1'\n  kk='2' k=\"1\"\n></A></Node>");
}

TEST(SceneText, TwoMissingAttributesOfOneTagAreBothAdded) {
  const std::string text = "<Node><A j='1'/></Node>";
  const TextPosition tag = at(read(text).components.at(0).where);
  EXPECT_EQ(changedText(text, {{tag, "l", "3"}, {tag, "k", "1"}, {tag, "j", "7"}, {tag, "k", "2"}}),
            "<Node><A j='7' k=\"2\" l=\"3\"/></Node>");
}

TEST(SceneText, AnAttributeIsChangedByItsOwnPlace) {
  const std::string text = "<Node><include href='b.xml' fem__k='1'/><A k=\"2\"/></Node>";
  const NodeDescription root = read(text);
  EXPECT_EQ(changedText(text, {{at(root.components.at(1).find("k")->where), "k", "4"},
                               {at(root.components.at(0).find("fem__k")->where), "k", "3"}}),
            "<Node><include href='b.xml' fem__k='3'/><A k=\"4\"/></Node>");
}

TEST(SceneText, ColumnsCountCharactersAndNotBytes) {
  const std::string before =
                        "\xEF\xBB\xBF<Node name='\xC3\xA9'><!-- \xE2\x82\xAC\xF0\x9F\xAB\x80 --><A n='\xC3\xA9' k='",
                    after = "'/></Node>";
  EXPECT_EQ(change(before + "2" + after, "\xE2\x82\xAC"), before + "\xE2\x82\xAC" + after);
}

TEST(SceneText, TheQuotesInUseAreEscapedAndTheOthersNot) {
  EXPECT_EQ(change("<Node><A k='1'/></Node>", "a'b\"c"), "<Node><A k='a&apos;b\"c'/></Node>");
  EXPECT_EQ(change("<Node><A k=\"1\"/></Node>", "a'b\"c"), "<Node><A k=\"a'b&quot;c\"/></Node>");
  EXPECT_EQ(change("<Node><A k=\"1\"/></Node>", "1 < 2 & 3 > 2"), "<Node><A k=\"1 &lt; 2 &amp; 3 > 2\"/></Node>");
}

/// Seeded values of every byte that XML can hold.
TEST(SceneText, TheReaderGivesEveryValueBack) {
  std::mt19937 random(7);
  const std::string texts[] = {"<Node><A k='1' j='2'/></Node>", "<Node><A k=\"1\" j='2'/></Node>",
                               "<Node><A j='2'/></Node>"};
  const std::vector<std::string> pieces = {"&",  "&amp;", "&#10;",    "<",   ">",   "'",   "\"", "\n", "\r\n", "\r",
                                           "\t", " ",     "\xC3\xA9", "]]>", "-->", "&lt", ";",  "a",  "1"};
  for (int i = 0; i < 300; ++i) {
    std::string value;
    for (unsigned count = random() % 9; count > 0; --count) value += pieces[random() % pieces.size()];
    for (const std::string& text : texts) {
      const NodeDescription root = read(change(text, value));
      EXPECT_EQ(root.components.at(0).find("k")->value, value);
      EXPECT_EQ(root.components.at(0).find("j")->value, "2");
    }
  }
}

/// Seeded changes at once are the same as one after the other, whatever their order.
TEST(SceneText, ManyChangesAtOnce) {
  std::mt19937 random(11);
  for (int round = 0; round < 50; ++round) {
    std::string text = "<Node>";
    for (int i = 0; i < 8; ++i)
      text += std::string(random() % 3, '\n') + "<A" + (random() % 2 ? " k='old'" : "") +
              (random() % 2 ? "\n j=\"2\"" : "") + "/>";
    text += "</Node>";
    const NodeDescription root = read(text);
    std::vector<TextChange> changes;
    for (const ComponentDescription& component : root.components)
      if (random() % 2) changes.push_back({at(component.where), "k", std::to_string(random())});
    std::shuffle(changes.begin(), changes.end(), random);
    const NodeDescription result = read(changedText(text, changes));
    for (std::size_t i = 0; i < root.components.size(); ++i) {
      const AttributeDescription* before = root.components[i].find("k");
      std::string expected = before ? before->value : "none";
      for (const TextChange& each : changes)
        if (each.where.line == root.components[i].where.line && each.where.column == root.components[i].where.column)
          expected = each.value;
      const AttributeDescription* after = result.components.at(i).find("k");
      EXPECT_EQ(after ? after->value : "none", expected);
      EXPECT_EQ(result.components[i].attributes.size(), root.components[i].attributes.size() + (after && !before));
    }
  }
}

std::string refusal(const std::string& text, const TextChange& change) {
  try {
    changedText(text, {change});
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

TEST(SceneText, APlaceWithoutATagOrAnAttributeIsRefused) {
  const std::string text = "<Node>\n<A k='1'/> text</Node>";
  expectContains(refusal(text, {{9, 1}, "k", "1"}), "line 9, column 1");
  expectContains(refusal(text, {{1, 90}, "k", "1"}), "line 1, column 90");
  expectContains(refusal(text, {{2, 11}, "k", "1"}), "expected an element or an attribute");
  expectContains(refusal(text, {{2, 12}, "k", "1"}), "expected name=\"value\"");
  expectContains(refusal(text, {{2, 16}, "k", "1"}), "expected a start tag");
  expectContains(refusal(text, {{2, 1}, "k", std::string("a\0b", 3)}), "a byte that is 0");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma
