# SPDX-License-Identifier: MIT
"""A disk that forgets: replays what the preload library recorded (fault_record.h) and writes out
what could be found after the power went off at any moment.

The model knows no mercy beyond POSIX: bytes of a file are safe once the file was synced, names once
their directory was. Of the rest any bytes may be there, lost, or torn at a sector, and any number
of names; only changes of names in one directory come in their order, as every file system with a
journal keeps it.
"""
import os
import struct

HEAD = struct.Struct("<QQIIII")
CREATE, WRITE, TRUNCATE, SYNC, LINK, RENAME, UNLINK, MKDIR, RMDIR = range(1, 10)
SECTOR = 512
O_TRUNC = os.O_TRUNC


def read_record(path):
    """[(time, operation, path, other path, offset, data)] of one process."""
    with open(path, "rb") as file:
        text = file.read()
    operations, at = [], 0
    while at < len(text):
        time, offset, operation, n_path, n_other, n_data = HEAD.unpack_from(text, at)
        at += HEAD.size
        names = [text[at:at + n_path].decode(), text[at + n_path:at + n_path + n_other].decode()]
        at += n_path + n_other
        operations.append((time, operation, *names, offset, text[at:at + n_data]))
        at += n_data
    return operations


def apply(content, change):
    kind, offset, data = change
    if kind == TRUNCATE:
        content[:] = content[:offset] + bytes(max(0, offset - len(content)))
        return
    content.extend(bytes(max(0, offset + len(data) - len(content))))
    content[offset:offset + len(data)] = data


class File:
    def __init__(self):
        self.safe, self.pending = bytearray(), []

    def sync(self):
        for change in self.pending:
            apply(self.safe, change)
        self.pending.clear()

    def after_loss(self, how, rng):
        """Bytes found after a loss."""
        content = bytearray(self.safe)
        for kind, offset, data in self.pending:
            if how == "all":
                apply(content, (kind, offset, data))
            elif how == "zeros":  # the length was written, the data were not
                end = offset if kind == TRUNCATE else offset + len(data)
                content.extend(bytes(max(0, end - len(content))))
            elif how == "some" and rng.random() < 0.6:
                if kind == WRITE and rng.random() < 0.4:  # torn
                    first = rng.randrange(0, len(data) + 1, SECTOR)
                    data = data[:first] if rng.random() < 0.5 else data[first:]
                    offset += 0 if data is None or len(data) == first else first
                apply(content, (kind, offset, data))
        return bytes(content)


class Disk:
    """Names are of files (File) or directories (None)."""

    def __init__(self, root):
        self.root = root
        self.safe, self.live, self.pending = {root: None}, {root: None}, []

    def _name(self, *change):
        self.pending.append(change)
        self._apply_name(self.live, change)

    @staticmethod
    def _apply_name(names, change):
        """False where what it rests on is not there."""
        kind, path, other, file = change
        if kind in (CREATE, MKDIR):
            if os.path.dirname(path) not in names:
                return False
            names[path] = file
        elif kind == LINK:
            if os.path.dirname(other) not in names:
                return False
            names[other] = file
        elif kind == RENAME:
            if path not in names:
                return False
            names[other] = names.pop(path)
        else:
            names.pop(path, None)
        return True

    def replay(self, operation, path, other, offset, data):
        if operation == CREATE:
            if path not in self.live:
                self._name(CREATE, path, "", File())
            elif offset & O_TRUNC:
                self.live[path].pending.append((TRUNCATE, 0, b""))
        elif operation in (WRITE, TRUNCATE):
            if path in self.live:
                self.live[path].pending.append((operation, offset, data))
        elif operation == SYNC:
            self._sync(path)
        elif operation in (LINK, RENAME):
            self._name(operation, path, other, self.live[path])
        elif operation == MKDIR:
            self._name(MKDIR, path, "", None)
        else:
            self._name(operation, path, "", None)

    def _sync(self, path):
        file = self.live.get(path)
        if file is not None:
            file.sync()
            return
        left = []
        for change in self.pending:
            if os.path.dirname(change[1]) == path:
                self._apply_name(self.safe, change)
            else:
                left.append(change)
        self.pending = left

    def lose(self, how, rng, target):
        """Writes to the directory `target` what is found of the root after the power went off.
        how: 'none' (only what is safe), 'all' (everything), 'zeros', 'some'."""
        names, lost = dict(self.safe), set()
        for change in self.pending:
            folder = os.path.dirname(change[1])
            if how == "none" or (how == "some" and rng.random() < 0.2):
                lost.add(folder)
            if folder not in lost:
                self._apply_name(names, change)
        os.makedirs(target)
        for path, file in sorted(names.items()):
            if path == self.root:
                continue
            place = target + path[len(self.root):]
            if not os.path.isdir(os.path.dirname(place)):
                continue  # its directory was lost
            if file is None:
                os.mkdir(place)
            else:
                with open(place, "wb") as out:
                    out.write(file.after_loss(how, rng))


def committed(journal):
    """Rays that the bytes of a journal (io/map/journal.h) commit."""
    commit, at, rays = 5, 0, 0
    while at + 8 <= len(journal):
        kind, nbytes = struct.unpack_from("<II", journal, at)
        at += 8 + nbytes
        if kind == commit and at <= len(journal):
            rays = struct.unpack_from("<Q", journal, at - nbytes + 8)[0]
    return rays


class Journals:
    """Rays that journals have promised: those of the last commit that was synced, once the journal's
    name was too."""

    def __init__(self):
        self.written, self.synced, self.promised = {}, {}, {}
        self.named = set()

    def replay(self, operation, path, offset, data):
        if operation == SYNC:
            if path in self.written:
                self.synced[path] = committed(self.written[path])
            self.named.update(name for name in self.written if os.path.dirname(name) == path)
            self.promised.update((name, self.synced.get(name, 0)) for name in self.named)
        elif path.endswith(".journal") and operation == WRITE:
            apply(self.written.setdefault(path, bytearray()), (WRITE, offset, data))
        elif path.endswith(".journal") and operation == UNLINK:
            for known in (self.written, self.synced, self.promised):
                known.pop(path, None)
            self.named.discard(path)
