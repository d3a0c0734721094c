# SPDX-License-Identifier: LGPL-2.1-or-later
# Written in Python 2.
import Sofa

import helper_of_two


def createScene(rootNode):
    print "a scene of before"
    rootNode.findData('gravity').value = '0 0 -10'
    names = {'dofs': 1}
    if names.has_key('dofs'):
        body = rootNode.createChild('body')
    for index in xrange(1):
        helper_of_two.solvers(body)
        body.createObject('MechanicalObject', name='dofs', position='0 0 %d' % index)
        body.createObject('UniformMass', totalMass=1)
    rootNode.createObject('DefaultAnimationLoop')
    return 0
