"""Execute one plan under errors that the planner does not know: mass, shape, friction, delay."""

import numpy as np

import wholearm_ros as wa

scenario = wa.load_scenario('asymmetric_hexagon')
trajectory = wa.plan(scenario).trajectory
successes = 0
for draw in range(5):
    perturbation = wa.draw_perturbation(np.random.default_rng(draw), 1.0, scenario)
    run = wa.simulate(scenario, trajectory, backend='planar', perturbation=perturbation)
    verdict = wa.judge(scenario, run)
    successes += verdict.executed
    print(f'draw {draw}: {verdict.executed} {verdict.reason}')
print(f'{successes} of 5 at the goal')
