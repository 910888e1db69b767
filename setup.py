"""Build description, for pip and for colcon (ament_python) alike."""

import re
from glob import glob
from pathlib import Path

from setuptools import find_packages, setup

NAME = 'wholearm_ros'
NODES = [
    'contact_state_planner',
    'trajectory_generator',
    'reorientation',
    'mode_switcher',
    'velocity_controller',
    'torque_controller',
    'hand_hardware',
    'ros2_control_bridge',
    'object_observer',
    'bag_recorder',
    'bag_player',
]

# numpy, scipy: Ubuntu 24.04's own are allowed, because the messages of a sourced ROS 2 are compiled against them.
CORE = [
    'numpy>=1.26,<3',
    'scipy>=1.11,<2',
    'osqp~=1.0',
    'rosbags~=0.10',
    'numba~=0.61',
    'pydantic~=2.5',
    'pyyaml~=6.0',
    'matplotlib~=3.8',
    'pillow>=10.1',
    'typer~=0.12',
    'rich>=13,<16',
]
# Physics for the simulated hand, beside our own.
PYBULLET = 'pybullet~=3.2'  # a wheel up to Python 3.11; from 3.12 on pip compiles it
MUJOCO = [
    'mujoco-core~=4.0; python_version >= "3.11"',  # numpy only; not for Python 3.10
    'mujoco>=3.8,<4; python_version < "3.11"',
]
ROS_WHEELS = [
    'ros-jazzy-rclpy~=7.1',
    'ros-jazzy-common-interfaces~=5.3',
    'ros-jazzy-rmw-fastrtps-cpp~=8.4',
]
CLUSTER = [
    'distributed>=2024.1'
]  # `wholearm suite` on a Dask cluster; without it --jobs uses a plain pool of processes
CONSOLE = [
    'aiohttp>=3.10,<4',
    'ezdxf~=1.3',  # outlines from DXF
    'svgelements~=1.9',  # and from SVG
]  # `wholearm console`
DOCS = [
    'mkdocs-material~=9.5',
    'mkdocstrings[python]>=0.27,<2',
]  # `make docs`
TEST = [
    *CLUSTER,
    *CONSOLE,
    *DOCS,
    'pytest>=8,<10',
    'pytest-timeout~=2.3',
    'pytest-xdist>=3.6,<4',
    'pytest-benchmark>=4,<6',
    'hypothesis~=6.100',
    'import-linter~=2.1',
    'ruff>=0.9',
    'mypy>=1.14',
    'wheel>=0.40',  # the test of the wheel builds it without a network
    'selenium~=4.20',
    'nbclient~=0.10',  # runs the notebook of examples/
    'ipykernel>=6,<8',
]

# Off the repository the links and images of the README lead nowhere: they become text.
README = re.sub(
    r'!?\[([^\]]*)\]\((?!https?:)[^)]*\)', r'\1', Path('README.md').read_text(encoding='utf-8')
)

setup(
    name=NAME,
    version='0.1.0',
    description='Whole-arm manipulation of a slippery polygon, planned and executed on ROS 2',
    long_description=README,
    long_description_content_type='text/markdown',
    keywords=['manipulation', 'non-prehensile', 'whole-arm', 'contact planning', 'ROS 2'],
    classifiers=[
        'Development Status :: 4 - Beta',
        'Intended Audience :: Science/Research',
        'Operating System :: POSIX :: Linux',
        'Programming Language :: Python :: 3',
        *(f'Programming Language :: Python :: 3.{minor}' for minor in range(10, 14)),
        'Topic :: Scientific/Engineering',
    ],
    maintainer='The wholearm_ros developers',
    maintainer_email='wholearm-ros@users.noreply.example.org',
    license='Apache-2.0',
    python_requires='>=3.10,<3.14',
    packages=find_packages(exclude=['test', 'test.*']),
    package_data={
        f'{NAME}.console': ['assets/*'],
        f'{NAME}.report.html': ['assets/*'],
        f'{NAME}.ros.interface': ['profiles/*.xml'],
    },
    install_requires=CORE,  # plans, simulates with our own physics, reports
    extras_require={
        'pybullet': [PYBULLET],
        'mujoco': MUJOCO,
        'ros-wheels': ROS_WHEELS,
        'cluster': CLUSTER,
        'console': CONSOLE,
        'docs': DOCS,
        'test': TEST,
    },
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{NAME}']),
        (f'share/{NAME}', ['package.xml']),
        (f'share/{NAME}/config', sorted(glob('config/*'))),
        (f'share/{NAME}/launch', sorted(glob('launch/*.launch.py'))),
        # `ros2 run` looks in lib/<package>; pip puts console scripts into bin/ whatever setup.cfg says.
        (f'lib/{NAME}', sorted(glob('resource/executables/*'))),
    ],
    zip_safe=False,
    entry_points={
        'console_scripts': [f'{node} = {NAME}.nodes.{node}:main' for node in NODES]
        + [f'wholearm = {NAME}.cli.main:main']
    },
)
