// SPDX-License-Identifier: LGPL-2.1-or-later
// Attributes as SOFA reads them: words for its bools, brackets, numbers with something behind them; what it declares
// without effect, what it reads and we do not, and what it does not know either.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <sstream>

#include "framework/scene/change_table.h"
#include "framework/scene/common_attributes.h"
#include "framework/scene/text.h"
#include "tools/sofa/declared_attributes.h"
#include "tools/sofa/rewriting.h"

namespace stroma::sofa {

namespace {

template <class List>
bool contains(const List& list, std::string_view word) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

bool isDrawing(std::string_view name) {
  return contains(visualAttributes(), name) || name.starts_with("show") || name.starts_with("draw");
}

std::string lowerCase(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return text;
}

/// 0, 1, T, False and the like, or empty.
std::string asBool(const std::string& text) { return saysYes(text) ? "true" : saysNo(text) ? "false" : ""; }

/// A word of the choice: written in other case, as a bool, or as its number.
std::string asChoice(const ChoiceRef& choice, const std::string& text) {
  for (const std::string& word : choice.words)
    if (lowerCase(word) == lowerCase(text)) return word;
  if (const std::string truth = asBool(text); contains(choice.words, truth)) return truth;
  std::size_t number = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), number);
  return code == std::errc() && end == text.data() + text.size() && number < choice.words.size() ? choice.words[number]
                                                                                                : std::string();
}

/// The numbers at the start of each word, up to the first word that is none: what a stream reads. A group that is not
/// whole is left out; of a single number the first is taken.
std::string numbersIn(std::string text, bool whole_numbers, std::size_t most, std::size_t group) {
  for (char& c : text)
    if (c == '[' || c == ']' || c == ';' || c == '(' || c == ')') c = ' ';
  std::vector<std::string> numbers;
  Words words(text);
  for (std::string_view word = words.next(); !word.empty() && numbers.size() < most; word = words.next()) {
    double value = 0;
    const char* first = word.data() + (word[0] == '+' ? 1 : 0);
    const auto [end, code] = std::from_chars(first, word.data() + word.size(), value);
    constexpr double largest_whole = 9e18;
    if (code != std::errc() || (whole_numbers && !(std::abs(value) < largest_whole))) break;
    numbers.emplace_back(whole_numbers ? std::to_string(static_cast<long long>(value)) : std::string(first, end));
    if (end != word.data() + word.size() && *end != 'f' && *end != '.') break;
  }
  numbers.resize(numbers.size() / group * group);
  std::string joined;
  for (const std::string& number : numbers) joined += (joined.empty() ? "" : " ") + number;
  return joined;
}

/// Words that SOFA's lists of indices have 0 of: the first one that is no number at all, and the first one whose numbers count here.
/// And a range that is cut.
struct StrangeWords {
  std::string none, counted, cut;
};

/// A whole number, also one that is written as a fraction is; else 0.
long long indexOf(std::string_view word, StrangeWords& strange) {
  double value = 0;
  const char* first = word.data() + (word.starts_with("+") ? 1 : 0);
  const auto [end, code] = std::from_chars(first, word.data() + word.size(), value);
  constexpr double largest = 1e9;
  const bool is_number = code == std::errc() && end == word.data() + word.size();
  const bool is_whole = is_number && value >= 0 && value < largest && value == std::floor(value);
  if (is_whole && word.find_first_of(".eE") == word.npos) return static_cast<long long>(value);
  std::string& kind = is_whole ? strange.counted : strange.none;
  if (kind.empty()) kind = word.empty() ? " " : word;
  return is_whole ? static_cast<long long>(value) : 0;
}

/// Of a range. What is written of it is still a text that a native scene may have.
constexpr long long longest = 2000000;

/// The indices of a list: numbers, ranges a-b and a-b-step, and 0 for each word that is neither.
std::string indicesIn(std::string text, StrangeWords& strange) {
  std::string joined, whole;
  for (std::istringstream words(text); strange.counted.empty() && words >> whole;)
    if (whole.find_first_of(",;[](){}") != whole.npos) strange.counted = whole;
  std::replace_if(text.begin(), text.end(), [](char c) { return std::string_view(",;[](){}").find(c) != std::string_view::npos; }, ' ');
  for (std::istringstream words(text); words >> whole;) {
    const std::string_view word = whole;
    const auto dash = word.find('-', 1), second = dash == word.npos ? word.npos : word.find('-', dash + 2);
    const long long from = indexOf(word.substr(0, dash), strange);
    long long to = from, by = 1;
    if (dash != word.npos) to = indexOf(word.substr(dash + 1, second == word.npos ? second : second - dash - 1), strange);
    if (second != word.npos) by = indexOf(word.substr(second + 1), strange);
    if (strange.none == " ") strange.none = whole;  // nothing after a dash
    by = std::max(by, 1LL) * (to < from ? -1 : 1);
    if (std::abs(to - from) > longest) strange.cut = whole, to = from + (to < from ? -longest : longest);
    for (long long i = from; by > 0 ? i <= to : i >= to; i += by) joined += (joined.empty() ? "" : " ") + std::to_string(i);
  }
  return joined;
}

/// Not of other whole numbers, such as a localRange.
bool isListOfIndices(const Data& data) {
  const auto has = [&](const char* word) { return data.name().find(word) != std::string::npos; };
  return std::holds_alternative<std::vector<int>*>(data.pointer()) && (has("ndices") || has("ndex") || has("oint"));
}

/// What ends SOFA's reading of a list of numbers, or empty; lists of matrices have brackets and commas there too.
std::string stopOf(const Data& data, const std::string& text) {
  const bool is_list = std::visit(
      [](const auto& pointer) {
        using Pointer = std::decay_t<decltype(pointer)>;
        if constexpr (!requires { pointer->resize(1); }) return false;
        else return !std::is_same_v<Pointer, std::string*> && !std::is_same_v<Pointer, std::vector<std::string>*> &&
                    !std::is_same_v<Pointer, std::vector<bool>*> && !std::is_same_v<Pointer, std::vector<int>*>;
      },
      data.pointer());
  static const std::vector<std::string_view> of_matrices = {"vertexMass", "inertia", "rotation", "cluster", "affine", "scale", "weights"};
  const auto at = text.find_first_of(",;[](){}");
  return !is_list || contains(of_matrices, data.name()) || at == text.npos ? std::string() : text.substr(at, 1);
}

template <class T>
constexpr std::size_t groupOf() {
  if constexpr (std::is_same_v<T, Vec3>) return 3;
  if constexpr (requires { std::tuple_size<T>::value; }) return std::tuple_size_v<T>;
  return 1;
}

/// What SOFA would read from `text` where our parser refuses it, or empty.
std::string repaired(const Data& data, const std::string& text) {
  return std::visit(
      [&](const auto& pointer) -> std::string {
        using Pointer = std::decay_t<decltype(pointer)>;
        if constexpr (std::is_same_v<Pointer, ChoiceRef>) {
          return asChoice(pointer, text);
        } else if constexpr (std::is_same_v<Pointer, bool*>) {
          return asBool(text);
        } else if constexpr (std::is_same_v<Pointer, LinkBase*> || std::is_same_v<Pointer, std::string*> ||
                             std::is_same_v<Pointer, FileName*> || std::is_same_v<Pointer, std::vector<std::string>*>) {
          return {};
        } else if constexpr (std::is_same_v<Pointer, std::vector<bool>*>) {
          std::string joined;
          Words words(text);
          for (std::string word(words.next()); !word.empty(); word = words.next())
            joined += (joined.empty() ? "" : " ") + asBool(word);
          return joined;
        } else {
          using Value = std::decay_t<decltype(*pointer)>;
          if constexpr (std::is_same_v<Value, Vec3>) {  // which could be resized, and is no list
            return numbersIn(text, false, 3, 3);
          } else if constexpr (std::is_arithmetic_v<Value>) {
            return numbersIn(text, std::is_same_v<Value, int>, 1, 1);
          } else if constexpr (requires { pointer->resize(1); }) {
            using Item = typename Value::value_type;
            constexpr bool whole = !std::is_same_v<Item, double> && !std::is_same_v<Item, Vec3>;
            return numbersIn(text, whole, std::size_t(-1), groupOf<Item>());
          } else {
            constexpr bool whole = std::is_same_v<Value, std::array<int, 3>>;
            return numbersIn(text, whole, groupOf<Value>(), groupOf<Value>());
          }
        }
      },
      data.pointer());
}

}  // namespace

void Rewriting::rewriteAttributes(Element& element) {
  if (!element.probe || element.without_effect) return;
  rewriteTemplate(element);
  if (const AttributeDescription* choice = element.find("template")) element.probe->chooseTemplate(choice->value);
  std::vector<std::string> given;
  std::erase_if(element.written->attributes, [&](AttributeDescription& attribute) {
    if (!keepsAttribute(element, attribute)) return true;
    const Data* data = element.probe->data().find(attribute.name);
    if (!data || data->link()) return false;
    if (contains(given, data->name())) {
      warn(attribute.where, element, attribute.name, "is given twice: the first counts");
      return true;
    }
    given.push_back(data->name());
    return false;
  });
}

bool Rewriting::keepsAttribute(Element& element, AttributeDescription& attribute) {
  if (attribute.name.starts_with("_") || attribute.name.starts_with("NO")) return false;
  if (attribute.name == "name" || attribute.name == "src" || attribute.name == "template") return true;
  if (hasNoEffect(element.written->type, attribute.name))
    return noEffect(element.written->type + "." + attribute.name), false;
  for (const AttributeChange& change : attributeChanges())
    if (change.type == element.written->type && change.old_attribute == attribute.name)
      attribute.name = std::string(change.new_attribute);
  Data* data = element.probe->data().find(attribute.name);
  return data ? keepsValue(element, *data, attribute) : keepsUnknown(element, attribute);
}

/// SOFA's fields of linear elasticity put 0.45 in the place of each value out of [0, 0.5); its materials take any.
static bool mendsPoissonRatio(std::string_view type) {
  static const std::vector<std::string_view> all = {
      "TetrahedronFEMForceField", "HexahedronFEMForceField", "TetrahedralCorotationalFEMForceField", "CorotationalFEMForceField",
      "FastTetrahedralCorotationalForceField", "HexahedralFEMForceField", "TriangularFEMForceField", "TriangleFEMForceField",
      "LinearSmallStrainFEMForceField"};
  return std::find(all.begin(), all.end(), type) != all.end();
}

/// A list as SOFA reads it, where that is not how it is read here.
void Rewriting::readList(const Element& element, const Data& data, AttributeDescription& attribute, const std::string& text) {
  if (attribute.typed) return;
  if (const std::string stop = stopOf(data, text); !stop.empty())
    warn(attribute.where, element, attribute.name, "SOFA reads its numbers up to " + inQuotes(stop) + " alone: here all of them count");
  if (!isListOfIndices(data)) return;
  StrangeWords strange;
  const std::string indices = indicesIn(text, strange);
  if (!strange.cut.empty())
    warn(attribute.where, element, attribute.name, inQuotes(strange.cut) + fmt::format(" is cut to {} numbers", longest + 1));
  if (!strange.none.empty())
    warn(attribute.where, element, attribute.name, inQuotes(strange.none) + " is no whole number: SOFA has 0 of it, and so has this scene");
  if (!strange.counted.empty())
    warn(attribute.where, element, attribute.name, "SOFA has 0 of a word like " + inQuotes(strange.counted) + ": here its numbers count");
  if (!strange.none.empty() || !strange.counted.empty() || text.find('-') != text.npos) attribute.value = indices;
}

bool Rewriting::keepsValue(Element& element, Data& data, AttributeDescription& attribute) {
  if (attribute.name == "poissonRatio" && mendsPoissonRatio(element.written->type) && !attribute.value.starts_with("@")) {
    std::string mended;
    double out = 0;
    bool is_out = false;
    for (const double ratio : writtenNumbers(attribute.value)) {
      const bool is_in = ratio >= 0 && ratio < 0.5;
      if (!is_in) out = ratio, is_out = true;
      mended += (mended.empty() ? "" : " ") + printReal(is_in ? ratio : 0.45);
    }
    if (is_out) {
      warn(attribute.where, element, attribute.name, printReal(out) + " is outside of [0, 0.5): SOFA takes 0.45 in its place");
      attribute.value = mended;
    }
  }
  const std::string text(trimmed(attribute.value));
  if (text.starts_with("@") || data.link()) return !text.empty();
  if (text.empty() && attribute.name == "indices" && holdsFirstNode(element.written->type)) return true;
  if (text.empty() && !attribute.typed && data.defaultText().empty()) return false;  // as scenes that a program saved have it
  if (data.isOutput()) {
    warn(attribute.where, element, attribute.name, "is computed by the component: what is written does not count");
    return false;
  }
  readList(element, data, attribute, text);
  std::optional<Problem> problem = data.parse(attribute.value, DataOrigin::written);
  if (!problem && attribute.typed) return true;
  if (!problem) {  // a stream does not know fractions
    if (text.find('/') == std::string::npos) return true;
    const bool is_vector = std::holds_alternative<Vec3*>(data.pointer());
    const std::string read = is_vector ? readByStream(text, data.defaultText()) : repaired(data, text);
    if (read.empty() || read == text) return true;
    attribute.value = read;
    warn(attribute.where, element, attribute.name,
         inQuotes(text) + " is no value: SOFA has " + read + " of it, and so has this scene");
    return true;
  }
  const bool is_linear = text == "linear" && element.written->type == "FastTetrahedralCorotationalForceField";
  const std::string other = is_linear ? "none" : repaired(data, text);
  if (!other.empty() && other != text) {
    if (!data.parse(other, DataOrigin::written)) {
      attribute.value = other;
      return true;
    }
  }
  // the answer of SOFA's fields to a value out of [0, 0.5); its materials take any
  if (attribute.name == "poissonRatio" && element.role() != "hyperelastic material") {
    warn(attribute.where, element, attribute.name, problem->message + ": SOFA takes 0.45 in its place");
    attribute.value = "0.45";
    return true;
  }
  if (!data.rangeText().empty() && problem->message.find("outside the range") != std::string::npos) return true;  // refused later
  if (std::holds_alternative<Vec3*>(data.pointer())) {
    attribute.value = readByStream(text, data.defaultText());
    warn(attribute.where, element, attribute.name, problem->message + ": SOFA has " + attribute.value + " of it, and so has this scene");
    return true;
  }
  warn(attribute.where, element, attribute.name,
       problem->message + ": SOFA keeps the default, and so does this scene");
  return false;
}

bool Rewriting::keepsUnknown(Element& element, const AttributeDescription& attribute) {
  const std::string& type = element.written->type;
  const std::string& abroad = element.type_abroad.empty() ? type : element.type_abroad;
  const DeclaredAttribute* declared = findDeclared(abroad, attribute.name);
  if (contains(commonAttributes(), attribute.name)) return true;
  if (isDrawing(attribute.name) || element.probe->data().isVisualOnly(attribute.name))
    return noEffect(type + "." + attribute.name), false;
  if (trimmed(attribute.value).empty() && !attribute.typed) return noEffect(type + "." + attribute.name), false;
  if (declared || isReadBySofa(type, attribute.name)) {
    const bool is_default = !attribute.typed && declared && isDefault(*declared, trimmed(attribute.value));
    if (is_default || isSofasDefault(attribute.name, trimmed(attribute.value)))
      return noEffect(type + "." + attribute.name), false;
    diagnostics_.error(attribute.where, element.path() + "." + attribute.name,
                       "SOFA's " + abroad + " reads " + inQuotes(attribute.name) +
                           ", which is not available here: without it the result would be another");
    return false;
  }
  std::vector<std::string> names = element.probe->data().names();
  for (const DeclaredAttribute& other : declaredAttributes(abroad)) names.emplace_back(other.name);
  const std::string also = declaredAttributes(abroad).empty() ? " here: " : ", nor has SOFA's: ";
  warn(attribute.where, element, attribute.name,
       type + " has no attribute " + inQuotes(attribute.name) + also + "the scene runs without it", nearest(attribute.name, names));
  return false;
}

/// Of what becomes another part here: attributes that SOFA's component has not either.
void Rewriting::tellUnread(const Element& element) {
  static const std::map<std::string, std::vector<std::string>> read = {
      {"Gravity", {"gravity"}},
      {"DampVelocitySolver", {"rate", "threshold", "threadSafeVisitor"}},
      {"MultiStepAnimationLoop", {"collisionSteps", "integrationSteps", "computeBoundingBox", "parallelODESolving"}}};
  const auto names = read.find(element.written->type);
  if (names == read.end()) return;
  for (const AttributeDescription& attribute : element.written->attributes)
    if (const std::string& name = attribute.name;
        !contains(names->second, name) && !contains(commonAttributes(), name) && !isDrawing(name) && name != "template" && name != "name")
      warn(attribute.where, element, name, element.written->type + " has no attribute " + inQuotes(name) + ": the scene runs without it",
           nearest(name, names->second));
}

/// In the words of today: Rigid3 for Rigid, Rigid3d, CudaRigid3f and others.
static std::string presentTemplate(std::string_view written) {
  std::string text(trimmed(written));
  for (const auto& [old, present] : std::vector<std::pair<std::string, std::string>>{
           {" ", ""}, {"Cuda", ""}, {"Ext", ""}, {"f1", "f"}, {"StdVec3Types", "Vec3"}, {"StdRigidTypes", "Rigid3"},
           {"Rigid3Types", "Rigid3"}, {"Vec3Types", "Vec3"}, {"Rigid3d", "Rigid3"}, {"Rigid3f", "Rigid3"}, {"Vec3d", "Vec3"},
           {"Vec3f", "Vec3"}, {"Vec1d", "Vec1"}, {"Vec1f", "Vec1"}, {"Vec2d", "Vec2"}, {"Vec2f", "Vec2"}, {"Vec6d", "Vec6"},
           {"Vec6f", "Vec6"}})
    for (auto at = text.find(old); at != std::string::npos; at = text.find(old)) text.replace(at, old.size(), present);
  for (std::size_t at = text.find("Rigid"); at != std::string::npos; at = text.find("Rigid", at + 1))
    if (const std::size_t end = at + 5; end == text.size() || text[end] == ',') text.insert(end, "3");  // "Rigid,Vec3"
  return text;
}

/// A template that does not exist, or that the state has not: SOFA takes one that fits.
void Rewriting::checkTemplate(const Element& element, const std::string& text) {
  static const std::vector<std::string> nodes{"Vec3", "Rigid3", "Vec1", "Vec2", "Vec6", "Rigid2"};
  static const std::vector<std::string> matrices{"GraphScattered", "CompressedRowSparseMatrix", "CompressedRowSparseMatrixMat3x3",
                                                 "ParallelGraphScattered", "BlockDiagonalMatrix", "DiagonalMatrix", "BTDMatrix",
                                                 "FullMatrix", "SparseMatrix", "RotationMatrix", "EigenSparseMatrix"};
  const std::string role = element.role(), word = text.substr(0, text.find(','));
  const SourceLocation& where = element.find("template")->where;
  const auto fits = [&](const std::string& known) { return word.starts_with(known); };
  const bool solves = role == "linear solver" || role == "preconditioner";
  const bool acts = role == "mass" || role == "force field" || role == "projective constraint";
  if (text.empty() || (!solves && !acts)) return;
  const std::vector<std::string>& list = solves ? matrices : nodes;
  if (std::none_of(list.begin(), list.end(), fits))
    return warn(where, element, "template", inQuotes(word) + " is no template: SOFA takes another one, and so does this scene",
                nearest(word, list));
  for (const char* elsewhere : {"object1", "object2", "mstate", "mstate1", "mstate2"})
    if (element.find(elsewhere)) return;
  const Element* state = acts ? element.place->nearest("mechanical state") : nullptr;
  if (!state || word[word.size() - 1] == '2') return;
  const std::string has = state->find("template") ? presentTemplate(state->text("template")) : "Vec3";
  if (std::find(nodes.begin(), nodes.end(), has) != nodes.end() && !has.ends_with('2') && !word.starts_with(has))
    warn(where, element, "template", "is " + word + ", and " + state->path() + " has " + has + ": SOFA takes the one that fits, and so "
         "does this scene", has);
}

/// Vec3d, Vec3f and CudaVec3f are Vec3, Rigid3d is Rigid3; a template of what has none is left out.
void Rewriting::rewriteTemplate(Element& element) {
  const AttributeDescription* found = element.find("template");
  if (!found) return;
  if (found->value.find("Cuda") != std::string::npos) noEffect("Cuda in the template of " + element.written->type);
  std::string text = presentTemplate(found->value);
  checkTemplate(element, text);
  if (element.role() == "mechanical state" && (text.starts_with("vec") || text.starts_with("Vec3,"))) {
    warn(found->where, element, "template", inQuotes(text) + " is no template: SOFA takes Vec3, and so does this scene", "Vec3");
    text.clear();
  }
  const bool solves = element.role() == "linear solver" || element.role() == "preconditioner";
  const bool is_form = text == "GraphScattered" || text.starts_with("CompressedRowSparseMatrix");
  if (solves && is_form && text.ends_with("f")) text.pop_back();  // of single precision
  if (text.empty() || !element.probe->data().find("template") || (solves && !is_form))
    return element.remove("template");
  element.set("template", text);
}

}  // namespace stroma::sofa
