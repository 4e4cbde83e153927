"""Writes the frames of a TUM folder as ROS bags with third-party programs.

    write_bags.py FOLDER OUTPUT     OUTPUT/room{,_lz4,_bz2}.bag, room{,_lz4,_zstd,_plain}.mcap, room.db3

rosbag (python3-rosbag) writes ROS 1 bags, @mcap/core (npm) writes MCAP files, and SQLite writes the
database of ROS 2. Files of missing programs are skipped with a message. Colour is registered to depth.
Depth counts are not scaled.
"""

import base64
import json
import pathlib
import re
import sqlite3
import subprocess
import sys

import numpy
from PIL import Image

FRAME = "camera_optical_frame"
HERE = pathlib.Path(__file__).resolve().parent


def camera_of(folder):
    """Width, height, fx, fy, cx, cy of depth_camera in camera.yaml."""
    text = (folder / "camera.yaml").read_text()
    block = text[text.index("depth_camera"):]
    number = lambda key: float(re.search(rf"\b{key}:\s*([-0-9.e+]+)", block)[1])
    return [number(key) for key in ("width", "height", "fx", "fy", "cx", "cy")]


def listed(folder, name):
    rows = [line.split() for line in (folder / name).read_text().splitlines() if line[:1] != "#"]
    return [(row[0], folder / row[1]) for row in rows if row]


def time_of(stamp):
    """Exact seconds and nanoseconds of a decimal timestamp."""
    whole, _, part = stamp.partition(".")
    return int(whole), int((part + "0" * 9)[:9])


def header(time):
    return {"stamp": {"sec": time[0], "nanosec": time[1]}, "frame_id": FRAME}


def image(stamp, path, encoding):
    pixels = numpy.array(Image.open(path)).astype("<u2" if encoding == "16UC1" else "u1")
    height, width = pixels.shape[:2]
    time = time_of(stamp)
    return time, {"header": header(time), "height": height, "width": width, "encoding": encoding,
                  "is_bigendian": 0, "step": pixels.nbytes // height, "data": pixels.tobytes()}


def info(time, camera):
    width, height, fx, fy, cx, cy = camera
    return {"header": header(time), "height": int(height), "width": int(width),
            "distortion_model": "plumb_bob", "d": [0.0] * 5, "k": [fx, 0, cx, 0, fy, cy, 0, 0, 1],
            "r": [1, 0, 0, 0, 1, 0, 0, 0, 1], "p": [fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0],
            "binning_x": 0, "binning_y": 0,
            "roi": {"x_offset": 0, "y_offset": 0, "height": 0, "width": 0, "do_rectify": False}}


def messages_of(folder):
    """(topic, type, time, message) of all messages, sorted by time."""
    camera = camera_of(folder)
    found = []
    for name, topic, encoding in (("depth.txt", "/camera/depth", "16UC1"),
                                  ("rgb.txt", "/camera/rgb", "rgb8")):
        for stamp, path in listed(folder, name):
            time, message = image(stamp, path, encoding)
            found.append((f"{topic}/image_raw", "sensor_msgs/Image", time, message))
            found.append((f"{topic}/camera_info", "sensor_msgs/CameraInfo", time,
                          info(time, camera)))
    return sorted(found, key=lambda one: one[2])


def write_ros1(messages, path, compression):
    import rosbag
    import rospy
    import sensor_msgs.msg

    def fill(target, values):
        for name, value in values.items():
            name = name.upper() if name in ("d", "k", "r", "p") else name
            if name == "stamp":
                target.stamp = rospy.Time(value["sec"], value["nanosec"])
            elif isinstance(value, dict):
                fill(getattr(target, name), value)
            else:
                setattr(target, name, value)
        return target

    with rosbag.Bag(str(path), "w", compression=compression, chunk_threshold=20000) as bag:
        for topic, kind, time, message in messages:
            bag.write(topic, fill(getattr(sensor_msgs.msg, kind.split("/")[1])(), message),
                      rospy.Time(*time))


def write_mcap(messages, path, how):
    """Writes an MCAP file. Returns the messages in CDR."""
    as_json = [{"topic": topic, "type": kind.replace("/", "/msg/"), "time": time,
                "message": {name: base64.b64encode(value).decode() if isinstance(value, bytes)
                            else value for name, value in message.items()}}
               for topic, kind, time, message in messages]
    work = path.with_suffix(".json")
    work.write_text(json.dumps(as_json))
    done = subprocess.run(["node", HERE / "write_mcap.mjs", work, path, how], check=True,
                          stdout=subprocess.PIPE)
    work.unlink()
    return json.loads(done.stdout)


def write_db3(cdr, path):
    """Writes the tables of the sqlite3 storage plugin of rosbag2."""
    path.unlink(missing_ok=True)
    with sqlite3.connect(path) as database:
        database.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT "
                         "NOT NULL, serialization_format TEXT NOT NULL, offered_qos_profiles TEXT "
                         "NOT NULL)")
        database.execute("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, "
                         "timestamp INTEGER NOT NULL, data BLOB NOT NULL)")
        database.execute("CREATE INDEX timestamp_idx ON messages (timestamp ASC)")
        ids = {}
        for one in cdr:
            if one["topic"] not in ids:
                ids[one["topic"]] = len(ids) + 1
                database.execute("INSERT INTO topics VALUES (?, ?, ?, 'cdr', '')",
                                 (ids[one["topic"]], one["topic"], one["type"]))
            database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)",
                             (ids[one["topic"]], int(one["log_time"]),
                              base64.b64decode(one["data"])))


def main():
    folder, output = map(pathlib.Path, sys.argv[1:3])
    output.mkdir(parents=True, exist_ok=True)
    messages = messages_of(folder)
    try:
        import rosbag  # noqa: F401
        for name, compression in (("room", "none"), ("room_lz4", "lz4"), ("room_bz2", "bz2")):
            write_ros1(messages, output / f"{name}.bag", compression)
    except ImportError as error:
        print(f"no .bag: {error}")
    if not (HERE / "node_modules/@mcap/core").exists():
        print("no .mcap and .db3: @mcap/core (npm) is not installed")
        return
    for name, how in (("room_lz4", "lz4"), ("room_zstd", "zstd"), ("room_plain", "unchunked"),
                      ("room", "")):
        cdr = write_mcap(messages, output / f"{name}.mcap", how)
    write_db3(cdr, output / "room.db3")


if __name__ == "__main__":
    main()
