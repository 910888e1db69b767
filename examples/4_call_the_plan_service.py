"""Ask a running planner node for a plan.

Start the graph first: `ros2 launch wholearm_ros wholearm.launch.py`, or only the node:
`python -m wholearm_ros.nodes.contact_state_planner`.
"""

import rclpy
from std_srvs.srv import Trigger

rclpy.init()
node = rclpy.create_node('example_client')
client = node.create_client(Trigger, '/wholearm/contact_state_planner/plan_scenario')
client.wait_for_service()
future = client.call_async(Trigger.Request())
rclpy.spin_until_future_complete(node, future)
print(future.result().success, future.result().message)
node.destroy_node()
rclpy.shutdown()
