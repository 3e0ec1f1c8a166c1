"""The lab on model predictive control: what students write to plan the next second."""
