"""Plan for a polygon of your own: the keys are those of a scenario file (docs/your_polygon.md)."""

import wholearm_ros as wa

finger = {
    'length': 0.15,  # m
    'half_width': 0.006,
    'mass': 0.16,  # kg
    'rotor_inertia': 0.005,  # kg m²
    'angle_limits': [0.05, 3.09],  # rad
    'torque_limit': 7.0,  # N m
}
scenario = wa.parse_scenario(
    {
        'name': 'pentagon',
        'object': {
            'vertices': [[0.0, 0.0], [0.06, 0.0], [0.08, 0.06], [0.03, 0.1], [-0.02, 0.06]],
            'mass': 0.30,
        },
        'hand': {
            'left': {'axis': [-0.10, -0.02], **finger},
            'right': {'axis': [0.10, -0.02], **finger},
        },
        'palm': {'vertices': [[-0.15, 0.0], [0.15, 0.0]]},
        'gravity': {'acceleration': 9.81, 'tilt_deg': 15.0},
        'start': {'edge': 0, 'x': -0.01},
        'goal': {'edge': 4, 'direction': 'ccw'},
    }
)
result = wa.plan(scenario, wa.PlanRequest(candidates=5, moves=0))
print(result.plan.summary())
if result.trajectory is not None:
    print(result.trajectory.time_in_modes())  # mode → s
