# SPDX-License-Identifier: LGPL-2.1-or-later
"""Folders in which files are looked for."""
import os


class FileRepository:
    """The folders of an environment variable, after the current one."""

    def __init__(self, envVar="STROMA_DATA_PATH", relativePath=None, *_):
        self._variable = "STROMA_DATA_PATH" if envVar == "SOFA_DATA_PATH" else str(envVar)
        if relativePath:
            self.addLastPath(relativePath)

    def getPaths(self):
        return [each for each in os.environ.get(self._variable, "").split(os.pathsep) if each]

    def _set(self, folders):
        os.environ[self._variable] = os.pathsep.join(folders)

    def addFirstPath(self, path):
        self._set([os.path.abspath(str(path)), *self.getPaths()])

    def addLastPath(self, path):
        self._set([*self.getPaths(), os.path.abspath(str(path))])

    addPath = addLastPath

    def removePath(self, path):
        self._set(each for each in self.getPaths() if each != os.path.abspath(str(path)))

    def clear(self):
        self._set([])

    def getPathsJoined(self):
        return os.pathsep.join(self.getPaths())

    def getFirstPath(self):
        return (self.getPaths() or [""])[0]

    def _found(self, filename, basedir=""):
        places = (os.path.join(folder, str(filename)) for folder in [basedir or os.getcwd(), *self.getPaths()])
        return next((each for each in places if os.path.exists(each)), None)

    def getFile(self, filename, basedir=""):
        """Where it is; the name as it was given where it is nowhere."""
        return self._found(filename, basedir) or filename

    def findFile(self, filename, basedir=""):
        return self._found(filename, basedir) is not None

    def findFileFromFile(self, filename, basefile=""):
        return self.findFile(filename, os.path.dirname(str(basefile)))

    @staticmethod
    def relativeToPath(path, refPath, *_):
        """A path below a folder, from there on; another one as it is."""
        below = os.path.relpath(str(path), str(refPath))
        return str(path) if below.startswith(os.pardir) else below

    @staticmethod
    def entrySeparator():
        return os.pathsep

    def print(self):
        print(self.getPathsJoined())
