"""How all tests run: nothing is timed, since machines are noisy, and each process keeps to one core."""

import os

from hypothesis import HealthCheck, settings

# as many tests run at once as there are cores: where each also uses all cores, they take half as long again
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

settings.register_profile("untimed", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("untimed")
