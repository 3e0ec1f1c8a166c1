"""The lab "what do I do?": what students write to decide in traffic."""
