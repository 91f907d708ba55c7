"""The model server's topics for ROS 2 tools, read by Eclipse Cyclone DDS' own Python binding as a ROS 2 node reads them.

The types are written here from the message definitions of ROS 2 Humble and octomap_msgs 2, not from our IDL.
"""
import contextlib
import fcntl
import os
import subprocess
import tempfile
import time
from dataclasses import dataclass

SECONDS = 30


@contextlib.contextmanager
def domain_of_its_own():
    """A DDS domain that no other test uses, by the locks of common/dds/testing/test_domain.h."""
    for i in range(101):
        candidate = 1 + (os.getpid() + i) % 101
        if candidate == 42:
            continue
        with open(f"/tmp/periplus-test-domain-{candidate}", "a", encoding="ascii") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                continue
            yield candidate
            return
    raise RuntimeError("no free DDS domain for a test; are 100 tests running?")


def types_of_ros():
    from cyclonedds.idl import IdlStruct
    from cyclonedds.idl.types import float64, int8, int32, sequence, uint8, uint32

    @dataclass
    class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
        sec: int32
        nanosec: uint32

    @dataclass
    class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
        stamp: Time
        frame_id: str

    @dataclass
    class PointField(IdlStruct, typename="sensor_msgs::msg::dds_::PointField_"):
        name: str
        offset: uint32
        datatype: uint8
        count: uint32

    @dataclass
    class PointCloud2(IdlStruct, typename="sensor_msgs::msg::dds_::PointCloud2_"):
        header: Header
        height: uint32
        width: uint32
        fields: sequence[PointField]
        is_bigendian: bool
        point_step: uint32
        row_step: uint32
        data: sequence[uint8]
        is_dense: bool

    @dataclass
    class Octomap(IdlStruct, typename="octomap_msgs::msg::dds_::Octomap_"):
        header: Header
        binary: bool
        id: str
        resolution: float64
        data: sequence[int8]

    return Octomap, PointCloud2


def newest(participant, topic, kind):
    """The first sample that a volatile, reliable reader gets; None if there is none in time."""
    from cyclonedds.core import Policy, Qos
    from cyclonedds.sub import DataReader
    from cyclonedds.topic import Topic
    from cyclonedds.util import duration
    qos = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(1))
    reader = DataReader(participant, Topic(participant, topic, kind, qos=qos), qos=qos)
    end = time.monotonic() + SECONDS
    while time.monotonic() < end:
        for sample in reader.take(1):
            return sample
        time.sleep(0.05)
    return None


def listen(programs, work):
    """The model written as ball.periplus, on a server of its own: what its two topics say."""
    os.environ["CYCLONEDDS_URI"] = ('<General><Interfaces><NetworkInterface address="127.0.0.1" multicast="true"/></Interfaces>'
                                    "<AllowMulticast>spdp</AllowMulticast></General>")
    from cyclonedds.domain import DomainParticipant
    octomap, cloud = types_of_ros()
    with tempfile.TemporaryDirectory() as store, domain_of_its_own() as domain:
        subprocess.run([programs / "periplus-model", "import", work / "ball.periplus", "--store", store], check=True, stdout=subprocess.DEVNULL)
        server = subprocess.Popen([programs / "periplus-model-server", "--set", f"store_folder={store}"],
                                  env={**os.environ, "PERIPLUS_DOMAIN": str(domain)}, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            participant = DomainParticipant(domain)
            return newest(participant, "rt/octomap_binary", octomap), newest(participant, "rt/object_points", cloud)
        finally:
            server.terminate()
            server.wait(20)


def points_of(cloud):
    """Positions, normals and colours, found by the fields' names and offsets."""
    import numpy
    raw = numpy.array(cloud.data, dtype=numpy.uint8).reshape(cloud.height * cloud.width, cloud.point_step)
    at = {field.name: field.offset for field in cloud.fields if field.datatype == 7 and field.count == 1}

    def column(name):
        return raw[:, at[name]:at[name] + 4].copy().view(">f4" if cloud.is_bigendian else "<f4")[:, 0]

    bgr = raw[:, at["rgb"]:at["rgb"] + 3]
    return (numpy.stack([column(n) for n in ("x", "y", "z")], axis=1), numpy.stack([column(n) for n in ("normal_x", "normal_y", "normal_z")], axis=1),
            bgr[:, ::-1])
