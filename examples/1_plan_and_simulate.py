"""Plan a shipped scenario, execute it in simulation, judge the result and draw it."""

import wholearm_ros as wa

scenario = wa.load_scenario('asymmetric_hexagon')
result = wa.plan(scenario, wa.PlanRequest(seed=0))
print(result.plan.summary())

run = wa.simulate(scenario, result.trajectory, backend='planar')
verdict = wa.judge(scenario, run)
print('at the goal' if verdict.executed else f'not at the goal: {verdict.reason}')

view = wa.view_run(run, scenario)
for path in wa.write_figures('figures', result.plan, result.trajectory, view):
    print(path)
