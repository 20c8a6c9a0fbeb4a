#!/usr/bin/env python3
"""UNTESTED: a ROS 2 node that publishes the force of each channel as geometry_msgs/WrenchStamped (force along z).

Written after the documentation of rclpy; it has never been run. Needs clients/python, rclpy and geometry_msgs.
A channel without a number publishes nothing: whoever listens must look at the age of what it has.
"""

import cermd
import rclpy
from geometry_msgs.msg import WrenchStamped
from rclpy.node import Node


class ForceNode(Node):
    def __init__(self):
        super().__init__("cermd")
        self.declare_parameter("max_hz", 100.0)
        self.stream = cermd.readings(max_hz=self.get_parameter("max_hz").value)
        self.publishers_by_channel = {}
        self.create_timer(0.005, self.turn)

    def turn(self):
        while (reading := self.stream.get(timeout=0.0)) is not None:
            if reading.newtons is None:
                continue
            message = WrenchStamped()
            message.header.stamp.sec = int(reading.time.timestamp())
            message.header.stamp.nanosec = reading.time.microsecond * 1000
            message.header.frame_id = reading.channel
            message.wrench.force.z = reading.newtons
            self.publisher(reading.channel).publish(message)

    def publisher(self, channel):
        if channel not in self.publishers_by_channel:
            topic = "".join(c if c.isalnum() and c.isascii() else "_" for c in channel)
            self.publishers_by_channel[channel] = self.create_publisher(WrenchStamped, f"force/{topic}", 10)
        return self.publishers_by_channel[channel]


def main():
    rclpy.init()
    rclpy.spin(ForceNode())


if __name__ == "__main__":
    main()
