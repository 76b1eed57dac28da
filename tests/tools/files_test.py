# SPDX-License-Identifier: MIT
"""Files of JSON and CSV, and paths in messages."""

import contextlib
import io
import pathlib
import tempfile
import unittest

from maxlogdet_tools import files, project


class Files(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_csv_is_read_as_it_was_written(self):
        file = self.folder / "new" / "table.csv"
        with contextlib.redirect_stdout(io.StringIO()) as said:
            files.write_csv(file, ["a", "b"], [["1", "x, y"], ["2", 'a "quoted" word']])
        self.assertEqual(said.getvalue(), f"wrote {file}\n")
        self.assertEqual(file.read_bytes(), b'a,b\n1,"x, y"\n2,"a ""quoted"" word"\n')
        self.assertEqual(files.rows_of(file), [{"a": "1", "b": "x, y"}, {"a": "2", "b": 'a "quoted" word'}])

    def test_names_the_file_that_is_not_json(self):
        file = self.folder / "broken.json"
        with self.assertRaisesRegex(SystemExit, "broken.json: cannot be read"):
            files.json_of(file)
        file.write_text("{")
        with self.assertRaisesRegex(SystemExit, "broken.json: expected JSON"):
            files.json_of(str(file))

    def test_shows_paths_of_the_checkout_from_its_root(self):
        self.assertEqual(str(project.shown(project.ROOT / "docs/README.md")), "docs/README.md")
        self.assertEqual(project.shown(self.folder), self.folder)
        self.assertTrue((project.ROOT / "tools/maxlogdet_tools/project.py").is_file())


if __name__ == "__main__":
    unittest.main()
