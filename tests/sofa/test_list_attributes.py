# SPDX-License-Identifier: LGPL-2.1-or-later
"""tools/sofa/list_attributes.py, on sources in SOFA's style that are written here. Usage: test_list_attributes.py TREE"""
import os
import subprocess
import sys
import tempfile

TREE = os.path.abspath(sys.argv[1])
TOOL = os.path.join(TREE, "tools", "sofa", "list_attributes.py")
HEADER = """// initData(&none, "none", "in a comment")
namespace there {
template <class T> class Field : public core::behavior::ForceField<T> {
 public:
  Field() : d_reach(initData(&d_reach, 0.25_sreal, "reach", "how far, \\"really\\" (default=0.25)")) {}
  Data<double> d_reach;
};
template <class DataTypes>
class THERE_API Spring : public Field<DataTypes>, public virtual core::DataEngine {
  Data<Real> d_k; Data<vector<int>> d_list;
};
}
"""
SOURCE = """template <class DataTypes>
Spring<DataTypes>::Spring()
  : d_k ( initData ( &d_k, (Real)500, "stiffness", "of the spring, (default=500)"
                     " and more" ) )
  , d_list(initData(&d_list, "list", "no default"))
  , d_method(initData(&d_method, std::string("large"), "method", "large: displacements, small: none"))
  , d_axis(initData(&d_axis, type::Vec3(1,0,0), "axis", "x y z")) /* , initData(&no, "no", "") */
  , d_on(initData(&d_on, true, "on", "a flag"))
  , d_ratio(initData(&d_ratio, type::vector<Real>(1, static_cast<Real>(0.3)), "ratio", "a list with one value"))
  , d_range(initData(&d_range, Vec<2,int>(-1,-1), "range", "two"))
  , d_depth(initData(&d_depth, defaultDepth, "depth", ("computed " + std::to_string(defaultDepth)).c_str()))
  , l_topology(initLink("topology", "link to the topology container"))
{
  this->addAlias(&d_k, "k");
}
template <class DataTypes>
void Spring<DataTypes>::parse(core::objectmodel::BaseObjectDescription* arg) {
  if (arg->getAttribute("scale") != nullptr) setScale(arg->getAttributeAsFloat("scale", 1.0));
}
"""
EXPECTED = """Field: ForceField
  reach=0.25
Spring: Field
  stiffness|k=500 list method=large axis=1,0,0 on=1 ratio=0.3 range=-1,-1 depth topology scale
"""


def listed(folder, *more):
    done = subprocess.run([sys.executable, TOOL, folder, *more], capture_output=True, text=True, timeout=60)
    return done.returncode, done.stdout, done.stderr


with tempfile.TemporaryDirectory() as sources:
    os.makedirs(os.path.join(sources, "examples"))
    for name, text in (("Field.h", HEADER), ("Spring.inl", SOURCE), (os.path.join("examples", "No.h"), HEADER.replace("Field", "No"))):
        with open(os.path.join(sources, name), "w", encoding="utf-8") as out:
            out.write(text)
    assert listed(sources) == (0, EXPECTED, ""), listed(sources)
    assert listed(sources, "Field")[1] == "Field: ForceField\n  reach=0.25\n"
    code, _, err = listed(sources, "Nothing")
    assert code == 1 and "no class Nothing in " in err, err
    table = os.path.join(sources, "table.txt")
    for text, expected in ((EXPECTED, ""), (EXPECTED.replace(" list", "").replace("|k", "|kk"),
                                            "Spring: the table has not k list\nSpring: the sources have not kk\n")):
        with open(table, "w", encoding="utf-8") as out:
            out.write("# a comment\n\n" + text)
        code, out, err = listed(sources, "--compare", table)
        assert (code, out) == (1 if expected else 0, expected), out + err
# the table of the tree is in this form, and its classes derive from others of it
sys.path.append(os.path.dirname(TOOL))
import list_attributes  # noqa: E402 pylint: disable=wrong-import-position

known = list_attributes.read_table(os.path.join(TREE, "tools", "sofa", "declared_attributes.txt"))
assert len(known) > 100, len(known)
for name, (bases, attributes) in known.items():
    for base in bases:
        assert base in known, f"{name} derives from {base}"
    assert attributes or bases or name.startswith("RungeKutta"), name
