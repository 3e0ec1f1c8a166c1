#!/usr/bin/env bash
# The first node of the workshop: any program can be one.
echo "Hello World!"
