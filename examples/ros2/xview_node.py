# SPDX-License-Identifier: BSD-3-Clause
"""A node of ROS 2 that finds a robot in a map: PointCloud2 in, transform map -> odom out.

    xview serve town.xvm --socket /run/xview/town.sock
    python3 xview_node.py --ros-args -r points:=/velodyne_points -p socket:=/run/xview/town.sock -p robot:=husky

Each cloud is posted to the server with the pose that tf has of its sensor in `odom`; where the server says where that
is, map -> odom is broadcast ten times a second until it says otherwise. Needs rclpy, sensor_msgs_py, tf2_ros and
SciPy. It is not run by the tests.
"""
import http.client
import json
import socket

import numpy as np
import rclpy
from geometry_msgs.msg import TransformStamped
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.time import Time
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import PointCloud2
from sensor_msgs_py import point_cloud2
from tf2_ros import Buffer, TransformBroadcaster, TransformException, TransformListener


class UnixConnection(http.client.HTTPConnection):
    def connect(self):
        self.sock = socket.socket(socket.AF_UNIX)
        self.sock.connect(self.host)


class Localizer(Node):
    def __init__(self):
        super().__init__("xview")
        self.server = self.declare_parameter("socket", "/run/xview.sock").value
        self.robot = self.declare_parameter("robot", "robot").value
        self.tf = Buffer()
        self.listener = TransformListener(self.tf, self, spin_thread=True)
        self.broadcaster = TransformBroadcaster(self)
        self.sent = None
        self.create_timer(0.1, self.send)
        self.create_subscription(PointCloud2, "points", self.localize, 1)

    def send(self):
        if self.sent is not None:
            self.sent.header.stamp = self.get_clock().now().to_msg()
            self.broadcaster.sendTransform(self.sent)

    def localize(self, cloud):
        try:
            pose = self.tf.lookup_transform("odom", cloud.header.frame_id, Time.from_msg(cloud.header.stamp),
                                            Duration(seconds=0.2)).transform
        except TransformException as problem:
            return self.get_logger().warning(str(problem))
        points = point_cloud2.read_points_numpy(cloud, ["x", "y", "z"], skip_nans=True).astype("<f4")
        t, q, stamp = pose.translation, pose.rotation, cloud.header.stamp
        body = np.c_[points, np.zeros(len(points), "<f4")].tobytes()
        where = f"{stamp.sec}.{stamp.nanosec:09d} {t.x} {t.y} {t.z} {q.x} {q.y} {q.z} {q.w}"
        connection = UnixConnection(self.server)
        try:
            connection.request("POST", f"/track/{self.robot}", body, {"X-Pose": where})
            answer = json.loads(connection.getresponse().read())
        except (OSError, ValueError, http.client.HTTPException) as problem:
            return self.get_logger().error(f"{self.server}: {problem}")
        finally:
            connection.close()
        if "jump_m" in answer:
            self.get_logger().warning(f"the robot is {answer['jump_m']} m from where odometry had it")
        if answer.get("T_map_odom") is None:  # lost: nobody knows where odom is
            self.sent = None
            return self.get_logger().info(answer.get("reason", "no answer"))
        T = np.reshape(answer["T_map_odom"], (4, 4))
        sent = TransformStamped()
        sent.header.frame_id, sent.child_frame_id = "map", "odom"
        v, r = sent.transform.translation, sent.transform.rotation
        v.x, v.y, v.z = T[:3, 3].tolist()
        r.x, r.y, r.z, r.w = Rotation.from_matrix(T[:3, :3]).as_quat().tolist()
        self.sent = sent


rclpy.init()
rclpy.spin(Localizer())
